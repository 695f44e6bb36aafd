# SPDX-License-Identifier: Apache-2.0
"""Cameras and conventions."""
import copy
import ctypes
import dataclasses
import json
import pickle

import numpy as np
import pytest

import swiftgs
from conftest import listed
from swiftgs import _c


def test_a_camera_has_what_it_was_made_of():
    camera = swiftgs.Camera(64, 48, 50, cy=20, translation=(1, 2, 3), name="a.png")
    assert (camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy) == (64, 48, 50, 50, 32, 20)
    assert np.array_equal(camera.rotation, np.eye(3)) and np.array_equal(camera.position, [-1, -2, -3])
    assert np.array_equal(camera.viewmat[:3, 3], [1, 2, 3])
    assert repr(camera) == "<swiftgs.Camera 'a.png' 64x48, f 50, at (-1, -2, -3)>"
    same = swiftgs.Camera.from_matrices(camera.viewmat, camera.K, 64, 48, name="a.png")
    assert same == camera and hash(same) == hash(camera) and same != swiftgs.Camera(64, 48, 51)
    for copied in (copy.copy(camera), copy.deepcopy(camera), pickle.loads(pickle.dumps(camera))):
        assert copied == camera and copied.name == "a.png"


def test_a_camera_has_the_lens_that_it_was_given():
    assert swiftgs.Camera(64, 48, 50).model == "perspective" and not swiftgs.Camera(64, 48, 50).is_distorted
    camera = swiftgs.Camera(64, 48, 50, model="fisheye", radial=(0.1, 0.2), rational=[0.3], tangential=np.array([1, 2]),
                            prism=(3, 4))
    assert camera.model == "fisheye" and camera.radial == (0.1, 0.2, 0, 0) and camera.rational == (0.3, 0, 0)
    assert camera.tangential == (1, 2) and camera.prism == (3, 4) and camera.is_distorted
    assert repr(camera) == "<swiftgs.Camera 64x48, fisheye, distorted, f 50, at (0, 0, 0)>"
    assert camera != swiftgs.Camera(64, 48, 50, model="fisheye")
    assert pickle.loads(pickle.dumps(camera)) == camera and camera.scaled(2).radial == camera.radial
    same = swiftgs.Camera.from_matrices(camera.viewmat, camera.K, 64, 48, model="fisheye", radial=camera.radial,
                                        rational=camera.rational, tangential=camera.tangential, prism=camera.prism)
    assert same == camera
    for model in ("orthographic", "equirectangular"):
        assert swiftgs.Camera(64, 48, 50, model=model).scaled(0.5).model == model


def test_numbers_may_be_those_of_numpy():
    camera = swiftgs.Camera(np.int64(64), np.uint16(48), np.float32(50), translation=np.arange(3, dtype=np.float32))
    assert (camera.width, camera.height, camera.fx) == (64, 48, 50) and np.array_equal(camera.translation, [0, 1, 2])


def test_a_camera_looks_where_it_is_told():
    camera = swiftgs.Camera.look_at((0, 0, -2), (0, 0, 0), width=100, height=50, vertical_fov=np.pi / 2)
    assert camera.fy == pytest.approx(25) and np.allclose(camera.position, [0, 0, -2])
    assert np.allclose(camera.rotation @ [0, 0, 1], [0, 0, 1])
    half = camera.scaled(0.5)
    assert (half.width, half.height) == (50, 25) and half.fx == pytest.approx(camera.fx / 2)


def opengl(near=1.0, far=3.0):
    """View and projection from (0, 0, 4) to the origin, y up, 90 degrees, the principal point a quarter aside."""
    view = np.eye(4)
    view[2, 3] = -4
    projection = np.array([[1, 0, 0.5, 0], [0, 1, 0, 0], [0, 0, -(far + near) / (far - near),
                                                          -2 * far * near / (far - near)], [0, 0, -1, 0]])
    return view, projection


def test_a_camera_comes_from_matrices_and_gives_them():
    camera, stored = swiftgs.Camera.from_projection(*opengl(), 200, 100, "opengl", name="a")
    assert (camera.fx, camera.fy, camera.cx, camera.cy, camera.name) == (100, 50, 50, 50, "a")
    assert np.allclose(camera.position, [0, 0, 4]) and np.allclose(camera.rotation, np.diag([1, -1, -1]))
    assert isinstance(stored, swiftgs.StoredDepth) and np.allclose(stored, swiftgs.StoredDepth.perspective(1, 3))
    for found, wanted in zip(camera.matrices(1, 3, "opengl"), opengl()):
        assert np.allclose(found, wanted)
    for clip_space in ("vulkan", "direct3d"):
        back, stored = swiftgs.Camera.from_projection(*camera.matrices(1e4, 0.1, clip_space), 200, 100, clip_space)
        assert np.allclose(back.viewmat, camera.viewmat) and np.allclose(back.K, camera.K)
        assert np.allclose(stored, swiftgs.StoredDepth.perspective(1e4, 0.1), rtol=1e-9)


def test_a_camera_moves_around_a_point():
    camera = swiftgs.Camera.look_at((0, 0, -4), (0, 0, 0), width=100, height=50, vertical_fov=1)
    view = swiftgs.OrbitView(camera, (0, 0, 0))
    assert np.allclose(view.orbit(np.pi / 2).position, [4, 0, 0])
    assert np.allclose(view.orbit(0, np.pi / 4, 0.5).position, [0, -2**0.5, -2**0.5])
    assert np.allclose(swiftgs.OrbitView(camera, [0, 0, 1], [0, 3, 0]).orbit(np.pi / 2).position, [-5, 0, 1])


def test_cameras_of_a_file(tmp_path):
    entry = {"id": 0, "img_name": "a.jpg", "width": 40, "height": 30, "position": [0, 0, 1],
             "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "fx": 20, "fy": 21}
    (tmp_path / "cameras.json").write_text(json.dumps([entry, dict(entry, id=1, img_name="b.jpg")]))
    cameras = swiftgs.load_cameras(tmp_path / "cameras.json")
    assert [camera.name for camera in cameras] == ["a.jpg", "b.jpg"]
    assert cameras[0].fy == 21 and np.array_equal(cameras[1].position, [0, 0, 1])
    assert isinstance(cameras, list) and cameras == list(cameras) and cameras.notes == ()
    with pytest.raises(swiftgs.FileError, match="none.json"):
        swiftgs.load_cameras(tmp_path / "none.json")


def test_what_is_not_read_of_a_file_of_cameras_is_noted(tmp_path):
    frame = {"file_path": "a.png", "transform_matrix": np.eye(4).tolist(), "w": 64, "h": 48, "fl_x": 50, "exposure": 2}
    (tmp_path / "transforms.json").write_text(json.dumps({"frames": [frame, frame], "applied_scale": 0.5}))
    cameras = swiftgs.load_cameras(tmp_path)
    assert len(cameras) == 2 and len(cameras.notes) == 2 and "dataparser_transforms.json" in cameras.notes[0]
    assert cameras.notes[1] == "Keys that may change the picture were not read: exposure."
    copied = pickle.loads(pickle.dumps(cameras))
    assert isinstance(copied, swiftgs.Cameras) and copied == cameras and copied.notes == cameras.notes


def test_conventions_are_those_of_the_library():
    # The struct holds floats; the defaults of the class are the decimals.
    presets = swiftgs.Conventions.named("gsplat"), swiftgs.Conventions()
    for field in dataclasses.fields(swiftgs.Conventions):
        found, default = (getattr(preset, field.name) for preset in presets)
        assert found == (pytest.approx(default, rel=1e-7) if isinstance(default, float) else default), field.name
    inria = swiftgs.Conventions.named("inria")
    assert inria.near_plane == pytest.approx(0.2) and inria.clamp == "around-centre" and inria.cull_at_near
    khronos = swiftgs.Conventions.named("khronos")
    assert (khronos.order, khronos.alpha_max, khronos.stop, khronos.stop_at_equal) == ("distance", 1, 0, False)
    assert khronos.blur is None and khronos.colours is None
    with pytest.raises(swiftgs.InvalidArgument, match="nobody"):
        swiftgs.Conventions.named("nobody")


def test_each_number_of_the_conventions_reaches_the_library():
    words, given = {"clamp": _c.CLAMPS, "depth": _c.DEPTHS, "depth_at": _c.DEPTHS_AT, "order": _c.ORDERS,
                    "colours": _c.COLOURS, "antialiased": (False, True)}, {}
    for macro, member, value in listed("conventions.inc", 2):
        given = {**(given if macro == "ALSO" else {}), member: words[member][value] if member in words else value}
        struct = swiftgs.Frame.empty(4, 4, conventions=swiftgs.Conventions(**given))._conventions
        assert getattr(struct, member) == value and struct.size == ctypes.sizeof(struct)
