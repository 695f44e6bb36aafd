# SPDX-License-Identifier: Apache-2.0
"""Scenes from files, from arrays, to files."""
import dataclasses
import gc
import signal
import sys
import threading
import time

import numpy as np
import pytest

import swiftgs
from conftest import ARRAYS, Lent

MODEL = swiftgs.RenderingModel(blur=0.1, antialiased=True, order="distance", colours="linear")
PLY_NAMES = "x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3".split()


def ply_head(form, **elements):
    """The head of a PLY with elements of so many rows of these properties, all floats."""
    lines = ["ply", f"format {form} 1.0"]
    for name, (count, properties) in elements.items():
        lines += [f"element {name} {count}", *(f"property float {each}" for each in properties)]
    return "\n".join([*lines, "end_header", ""])


def same(first, second):
    return all(np.array_equal(getattr(first, name), getattr(second, name)) for name in ARRAYS)


def test_a_scene_tells_what_it_holds(scene):
    assert len(scene) == 2000 and scene.sh_degree == 3 and scene.model == swiftgs.RenderingModel()
    assert scene.format == "" and scene.stored == 2000 and scene.dropped == 0
    assert {name: getattr(scene, name).shape for name in ARRAYS} == {
        "means": (2000, 3), "scales": (2000, 3), "rotations": (2000, 4), "opacities": (2000,), "sh0": (2000, 3),
        "sh_rest": (2000, 15, 3)}
    assert scene.sh.shape == (2000, 16, 3) and np.array_equal(scene.sh[:, 1:], scene.sh_rest)
    lower, upper = scene.bounds
    assert np.array_equal(lower, scene.means.min(axis=0)) and np.array_equal(upper, scene.means.max(axis=0))
    assert repr(scene) == "<swiftgs.Scene of 2,000 Gaussians, SH degree 3>"


def test_a_scene_tells_where_it_lies_and_where_to_start(scene):
    bounds, view = scene.robust_bounds(), scene.default_view(64, 48)
    assert np.all(bounds.low < bounds.centre) and np.all(bounds.centre < bounds.high) and bounds.radius > 0
    assert (view.camera.width, view.camera.height) == (64, 48) and np.array_equal(view.target, bounds.centre)
    assert np.allclose(scene.default_view(up=(0, 0, -2)).up, (0, 0, -1))
    assert view.orbit(0.5).width == 64 and view.orbit(0.5) != view.camera


def test_arrays_are_the_scenes_memory_and_outlive_it():
    scene = swiftgs.Scene.builtin(5000)
    means = scene.means
    assert means.dtype == np.float32 and not means.flags.writeable
    assert means.__array_interface__["data"][0] == scene.means.__array_interface__["data"][0]
    copy = means.copy()
    scene.close()
    del scene
    gc.collect()
    swiftgs.Scene.builtin(5000)  # would take the memory again
    assert np.array_equal(means, copy)
    with pytest.raises(ValueError):
        means[0] = 1


def test_files_come_back_and_name_what_they_lose(scene, tmp_path):
    assert scene.save(tmp_path / "a.ply") == ()
    read = swiftgs.load(tmp_path / "a.ply")
    assert np.array_equal(read.means, scene.means) and np.array_equal(read.sh_rest, scene.sh_rest)
    assert "PLY" in read.format and "PLY" in repr(read)
    notes = scene.save(str(tmp_path / "b.bin"), format="splat")
    assert notes[-1].startswith("Rounding changes numbers at most: opacities by ")
    assert len(swiftgs.Scene.from_bytes((tmp_path / "b.bin").read_bytes(), "b.splat")) > 0
    scene.save(tmp_path / "c.spz", spz_version=3, spz_axes="rub")
    assert swiftgs.load(tmp_path / "c.spz").format == "SPZ version 3"


def test_gaussians_that_are_left_out_are_a_warning(tmp_path):
    numbers = np.ones((3, 14), np.float32)
    numbers[0, 10:] = 0
    numbers[1, 0] = np.nan
    head = ply_head("binary_little_endian", vertex=(3, PLY_NAMES))
    (tmp_path / "a.ply").write_bytes(head.encode() + numbers.tobytes())
    with pytest.warns(UserWarning, match="2 of 3 Gaussians are not finite or have no rotation"):
        scene = swiftgs.load(tmp_path / "a.ply")
    assert (len(scene), scene.dropped, scene.stored) == (1, 2, 3)
    assert scene.notes == ("Gaussians with a NaN or an infinity are left out: 1.",
                           "Gaussians whose quaternion is no rotation are left out: 1.")


def test_the_camera_of_a_photograph_comes_with_its_scene(scene, tmp_path):
    elements = {"extrinsic": np.eye(4).ravel(), "intrinsic": [40, 0, 24, 0, 41, 16, 0, 0, 1], "image_size": [48, 32]}
    head = ply_head("ascii", vertex=(1, PLY_NAMES), **{name: (len(of), [name]) for name, of in elements.items()})
    rows = ["0 0 1 0 0 0 0 0 0 0 1 0 0 0", *(str(number) for of in elements.values() for number in of)]
    (tmp_path / "a.ply").write_text(head + "\n".join(rows) + "\n")
    assert swiftgs.load(tmp_path / "a.ply").camera == swiftgs.Camera(48, 32, 40, 41)
    assert scene.camera is None


def test_files_that_are_no_scenes_have_errors_of_their_own(tmp_path):
    with pytest.raises(swiftgs.FileError, match="none.ply: No such file"):
        swiftgs.load(tmp_path / "none.ply")
    with pytest.raises(swiftgs.FormatError, match="x.ply: byte"):
        swiftgs.Scene.from_bytes(b"nothing", "x.ply")


def test_progress_is_told_and_cancels(tmp_path):
    scene = swiftgs.Scene.builtin(300_000)
    parts = []
    scene.save(tmp_path / "a.spz", progress=parts.append)
    assert parts == sorted(parts) and parts[-1] == 1
    for call in (lambda progress: scene.save(tmp_path / "b.spz", progress=progress),
                 lambda progress: swiftgs.load(tmp_path / "a.spz", progress=progress)):
        with pytest.raises(swiftgs.Cancelled):
            call(lambda part: False)
        with pytest.raises(ZeroDivisionError):
            call(lambda part: 1 / 0)
    assert not (tmp_path / "b.spz").exists()


def test_ctrl_c_stops_a_file(tmp_path):
    scene = swiftgs.Scene.builtin(1_000_000)
    begun = time.monotonic()
    threading.Timer(0.2, lambda: signal.raise_signal(signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        for _ in range(100):
            scene.save(tmp_path / "a.sog")
    assert time.monotonic() - begun < 10 and not list(tmp_path.glob("*"))


def test_a_closed_scene_says_so(scene):
    with swiftgs.Scene.builtin(10) as closed:
        assert len(closed) == 10
    for use in (lambda: closed.means, lambda: closed.save("a.ply"), closed.__enter__,
                lambda: swiftgs.Renderer("serial", scene=closed)):
        with pytest.raises(ValueError, match="the scene is closed"):
            use()
    assert repr(closed).endswith("closed>")


def test_arrays_become_the_same_scene(scene, arrays):
    assert same(swiftgs.Scene.from_arrays(**arrays, any_rotations=False), scene)
    by_dlpack = {name: Lent(array.copy()) for name, array in arrays.items()}
    assert same(swiftgs.Scene.from_arrays(**by_dlpack, any_rotations=False), scene)
    assert by_dlpack["means"].asked == [None]


def test_gaps_and_other_orders_are_taken(scene, arrays):
    rows = np.zeros((4000, 80), np.float32)[::2]
    at, in_rows = 1, {}
    for name, array in arrays.items():
        flat = array.reshape(2000, -1)
        rows[:, at:at + flat.shape[1]] = flat
        inner = {1: (), 2: (4,), 3: (12, 4)}[array.ndim]
        in_rows[name] = np.lib.stride_tricks.as_strided(rows[:, at:], array.shape, (rows.strides[0], *inner))
        at += flat.shape[1]
    assert in_rows["sh_rest"].strides[0] == 640 and np.shares_memory(in_rows["means"], rows)
    for given in (in_rows, {name: np.asfortranarray(array) for name, array in arrays.items()},
                  {name: np.array(array[::-1])[::-1] for name, array in arrays.items()}):
        assert same(swiftgs.Scene.from_arrays(**given, any_rotations=False), scene)
    one = dict(arrays, opacities=np.broadcast_to(np.float32(0.5), 2000))  # a stride of 0
    assert np.all(swiftgs.Scene.from_arrays(**one).opacities == 0.5)


def test_features_of_any_number_are_kept(arrays):
    assert swiftgs.Scene.from_arrays(**arrays).features.shape == (2000, 0)
    rows = np.random.default_rng(1).random((2000, 9), np.float32)
    for features in (rows[:, 2:7], Lent(rows[:, :4].copy()), np.asfortranarray(rows), rows[::-1]):
        scene = swiftgs.Scene.from_arrays(**arrays, features=features)
        assert np.array_equal(scene.features, getattr(features, "array", features))


def test_an_origin_comes_with_arrays_and_files(arrays, tmp_path):
    origin = np.array([1e7, -6378137, 4e6])
    near = swiftgs.Scene.from_arrays(**dict(arrays, means=np.round(arrays["means"] * 4096) / np.float32(4096)))
    far = swiftgs.Scene.from_arrays(**dict(arrays, means=near.means), origin=origin)
    assert not near.origin.any() and np.array_equal(far.origin, origin)
    assert any("doubles" in note for note in far.save(tmp_path / "far.ply"))
    read = swiftgs.load(tmp_path / "far.ply")
    assert any("relative to the origin" in note for note in read.notes)
    assert np.array_equal(read.origin + read.means, origin + near.means)
    beside = swiftgs.Camera.builtin(96, 64)
    assert np.allclose(beside.relative_to(-origin).position, beside.position + origin, rtol=0, atol=1e-7)


def test_numbers_are_activated_as_training_stores_them(arrays):
    raw = dict(arrays, scales=np.log(np.maximum(arrays["scales"], 1e-30)),
               opacities=np.log(arrays["opacities"] / (1 - np.minimum(arrays["opacities"], 0.999))),
               rotations=arrays["rotations"] * 3)
    scene = swiftgs.Scene.from_arrays(**raw, log_scales=True, logit_opacities=True, model=MODEL)
    assert np.allclose(scene.scales, np.maximum(arrays["scales"], 1e-30), rtol=1e-5)
    assert np.allclose(scene.opacities, arrays["opacities"], atol=2e-3)
    assert np.allclose(scene.rotations, arrays["rotations"], atol=1e-6)
    assert scene.model == dataclasses.replace(MODEL, blur=pytest.approx(0.1))
    del raw["sh0"], raw["sh_rest"]
    colours = np.random.default_rng(1).random((2000, 3), np.float32)
    plain = swiftgs.Scene.from_arrays(**raw, colours=colours)
    assert plain.sh_degree == 0 and np.allclose(plain.sh0 * 0.28209479 + 0.5, colours, atol=1e-6)


def test_a_capsule_is_held_as_long_as_its_memory_is_read_and_no_longer(arrays):
    means = arrays["means"].copy()
    before = sys.getrefcount(means)
    scene = swiftgs.Scene.from_arrays(**dict(arrays, means=Lent(means)))
    gc.collect()
    assert sys.getrefcount(means) <= before + 1
    del scene


def test_a_scene_may_be_closed_while_it_is_written(tmp_path):
    scene = swiftgs.Scene.builtin(50_000)
    scene.save(tmp_path / "closed.ply", progress=lambda part: scene.close())
    assert len(swiftgs.load(tmp_path / "closed.ply")) == 50_000
    with pytest.raises(ValueError, match="closed"):
        scene.means
