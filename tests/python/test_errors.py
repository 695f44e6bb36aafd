# SPDX-License-Identifier: Apache-2.0
"""Every refusal is a `swiftgs.Error`, in one line that names what was given."""
import ast
import inspect
import pathlib
import re
import types

import numpy as np
import pytest

import swiftgs
from conftest import HEIGHT, ROOT, WIDTH, listed
from swiftgs import _errors

# What Python itself asks for: `import` an ImportError, a missing member an AttributeError.
OF_PYTHON = {("_c.py", "ImportError"), ("_c.py", "AttributeError")}
BAD = object()  # nothing takes it
ZERO, HUGE = "a\0b", 1 << 70


def errors():
    return {name for name, found in vars(_errors).items() if isinstance(found, type) and issubclass(found, Exception)}


def test_the_package_raises_nothing_else():
    found = set()
    for path in sorted(pathlib.Path(swiftgs.__file__).parent.glob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call) and isinstance(node.exc.func, ast.Name):
                found.add((path.name, node.exc.func.id))
    found = {(file, name) for file, name in found if name not in errors() and name != "exception_of"}
    assert found == OF_PYTHON


def test_errors_are_public_and_those_of_python_too():
    assert errors() <= set(swiftgs.__all__)
    for kind, also in {"InvalidArgument": ValueError, "InvalidType": TypeError, "NotOffered": NotImplementedError,
                       "NotLent": BufferError, "NoSuchResult": KeyError, "FormatError": ValueError,
                       "FileError": OSError, "DeviceError": RuntimeError, "CapacityError": RuntimeError,
                       "OrderError": RuntimeError, "OutOfMemory": MemoryError, "Unavailable": RuntimeError,
                       "InternalError": RuntimeError}.items():
        error = getattr(swiftgs, kind)("one line")
        assert isinstance(error, swiftgs.Error) and isinstance(error, also) and str(error) == "one line"


def test_errors_have_the_codes_of_c():
    header = (ROOT / "include/swiftgs/c/status.h").read_text()
    codes = {name: int(code) for name, code in re.findall(r"SWIFTGS_([A-Z_]+) = (\d+)", header) if name != "OK"}
    assert sorted(codes.values()) == list(range(1, 11))
    for name, code in codes.items():
        kind = {"SYSTEM_ERROR": "FileError", "LOGIC_ERROR": "OrderError"}.get(name, name.title().replace("_", ""))
        error = _errors.exception_of(code, "one line")
        assert type(error) is getattr(swiftgs, kind) and error.code == code


def refusals(scene, camera, renderer, frame, arrays, gsplat, at):
    """(what is called, arguments that it refuses, words of the message)."""
    view = np.eye(4)
    orbit = swiftgs.OrbitView(camera, (0, 0, 0))
    cls, placement = swiftgs.Camera, swiftgs.Placement
    of = lambda **changed: [{**arrays, **changed}]  # noqa: E731
    zeros = lambda *shape, kind=np.float32: np.zeros(shape, kind)  # noqa: E731
    strided = np.lib.stride_tricks.as_strided
    place = lambda **given: renderer.place([placement(**given)])  # noqa: E731
    shear, mirror, row = np.eye(4), np.diag([1.0, 1, -1, 1]), np.eye(4)
    shear[0, 1], row[3, 0] = 0.5, 1
    look = {"width": 4, "height": 4, "vertical_fov": 1}
    pair, small = swiftgs.Frame.empty(WIDTH, HEIGHT, 2), cls.builtin(16, 16)
    recorded, reserved, drawn = (swiftgs.Renderer("cpu", scene=scene) for _ in range(3))
    reserved.reserve(camera, frame)
    pool = swiftgs.PagePool(drawn, swiftgs.open_pages(ROOT / "tests/fuzz/seeds/pages/tree.sgp"))
    drawn.render(camera)
    return [
        ("load", swiftgs.load, [5], "path is 5"), ("load", swiftgs.load, [ZERO], "zeros"),
        ("load", swiftgs.load, ["a.ply", {"spz_axes": 5}], "spz_axes is 5"),
        ("load", swiftgs.load, ["a.ply", {"level": "x"}], "level is 'x'"),
        ("load", swiftgs.load, [at, {"level": -1}], "level is -1, expected 0"),
        ("load", swiftgs.load, ["a.ply", {"level": HUGE}], "level is"),
        ("load", swiftgs.load, ["a.ply", {"progress": 5}], "progress is 5"),
        ("load_cameras", swiftgs.load_cameras, [None], "path is None"),
        ("load_image", swiftgs.load_image, [None], "path is None"),
        ("find_renderer", swiftgs.find_renderer, [5], "renderer is 5"),
        ("find_renderer", swiftgs.find_renderer, ["cpu\0"], "zeros"),
        ("Scene.builtin", swiftgs.Scene.builtin, [-1], "count is -1, expected 0 or more"),
        ("Scene.builtin", swiftgs.Scene.builtin, [2.5], "count is 2.5"),
        ("Scene.from_arrays", swiftgs.Scene.from_arrays, of(sh0=None), "either sh0 or colours"),
        ("Scene.from_arrays", swiftgs.Scene.from_arrays, of(origin="x"), "origin is 'x'"),
        ("Scene.from_arrays", swiftgs.Scene.from_arrays, of(origin=(1, 2)), "origin has the shape (2,)"),
        ("Scene.from_arrays", swiftgs.Scene.from_arrays, of(means=[1]), "means is of type list"),
        ("Scene.from_arrays", swiftgs.Scene.from_arrays, of(means=zeros(2000, 3, kind="f8")),
         "means has numbers of type f8, expected float32 (f4)"),
        ("Scene.from_arrays", swiftgs.Scene.from_arrays, of(means=zeros(2000, 3, kind=">f4")),
         "means has numbers of type !>f4"),
        ("Scene.from_arrays", swiftgs.Scene.from_arrays,
         of(means=zeros(24001, kind="u1")[1:].view(np.float32).reshape(2000, 3)), "expected a multiple of 4"),
        ("Scene.from_arrays", swiftgs.Scene.from_arrays, of(scales=zeros(2000, 2)),
         "scales has the shape (2000, 2), expected (2000, 3)"),
        ("Scene.from_arrays", swiftgs.Scene.from_arrays, of(opacities=zeros(1999)),
         "opacities has the shape (1999,), expected (2000)"),
        ("Scene.from_arrays", swiftgs.Scene.from_arrays, of(sh_rest=zeros(2000, 4, 3)),
         "sh_rest has 4 coefficients, expected 0, 3, 8, 15"),
        ("Scene.from_arrays", swiftgs.Scene.from_arrays, of(features=zeros(2000)),
         "features has the shape (2000,), expected (2000, N)"),
        ("Scene.from_arrays", swiftgs.Scene.from_arrays, of(model="x"), "model is of type str"),
        ("Scene.from_arrays", swiftgs.Scene.from_arrays, of(model=swiftgs.RenderingModel(order="z")), "order is 'z'"),
        ("Scene.from_bytes", swiftgs.Scene.from_bytes, [BAD, "a.ply"], "data is of type object"),
        ("Scene.from_bytes", swiftgs.Scene.from_bytes, [b"1", 5], "path is 5"),
        ("Scene.save", scene.save, [5], "path is 5"), ("Scene.save", scene.save, ["a", {"format": 5}], "format is 5"),
        ("Scene.save", scene.save, ["a.spz", {"spz_version": "x"}], "spz_version is 'x'"),
        ("Scene.save", scene.save, ["a.spz", {"progress": "x"}], "progress is 'x'"),
        ("Scene.default_view", scene.default_view, ["x"], "width is 'x'"),
        ("Scene.default_view", scene.default_view, [HUGE], "width is 1180591620717411303424"),
        ("Scene.default_view", scene.default_view, [{"up": "x"}], "up is 'x'"),
        ("Camera", cls, ["x", 4, 1], "width is 'x'"),
        ("Camera", cls, [np.int64(1 << 40), 4, 1], "width is 1099511627776"),
        ("Camera", cls, [4, 4, "x"], "fx is 'x'"), ("Camera", cls, [4, 4, 1, {"rotation": "x"}], "rotation is 'x'"),
        ("Camera", cls, [4, 4, 1, {"translation": 5}], "translation has the shape ()"),
        ("Camera", cls, [4, 4, 1, {"radial": "x"}], "radial is 'x'"),
        ("Camera", cls, [4, 4, 1, {"rotation": np.eye(2)}], "rotation has the shape (2, 2), expected (3, 3)"),
        ("Camera", cls, [4, 4, 1, {"radial": range(5)}], "radial has the shape (5,), expected at most 4 numbers"),
        ("Camera", cls, [4, 4, 1, {"model": "pinhole"}], "model is 'pinhole', expected one of perspective, fisheye"),
        ("Camera.from_matrices", cls.from_matrices, ["x", view, 4, 4], "viewmat is 'x'"),
        ("Camera.from_matrices", cls.from_matrices, [np.eye(3), np.eye(3), 4, 4], "viewmat has the shape (3, 3)"),
        ("Camera.from_projection", cls.from_projection, ["x", view, 4, 4, "opengl"], "view is 'x'"),
        ("Camera.from_projection", cls.from_projection, [view, view, 4, 4, "metal"],
         "clip_space is 'metal', expected one of opengl, vulkan, direct3d"),
        ("Camera.look_at", cls.look_at, ["x", (0, 0, 1), look], "eye is 'x'"),
        ("Camera.builtin", cls.builtin, [(1 << 32) + 4, 4], "width is 4294967300"),
        ("Camera.builtin", cls.builtin, [4, 4.5], "height is 4.5"),
        ("Camera.scaled", camera.scaled, ["x"], "scale is 'x'"),
        ("Camera.relative_to", camera.relative_to, [5], "origin has the shape ()"),
        ("Camera.matrices", camera.matrices, ["x", 1, "opengl"], "at_0 is 'x'"),
        ("Camera.matrices", camera.matrices, [0.1, 1, None], "clip_space is None"),
        ("OrbitView.orbit", orbit.orbit, ["x"], "turn is 'x'"),
        ("OrbitView.orbit", swiftgs.OrbitView(camera, (0, 0, 0), (0, 0, 0)).orbit, [1], "up is (0.0, 0.0, 0.0)"),
        ("StoredDepth.perspective", swiftgs.StoredDepth.perspective, ["x", 1], "at_0 is 'x'"),
        ("StoredDepth.orthographic", swiftgs.StoredDepth.orthographic, [0, "x"], "at_1 is 'x'"),
        ("Conventions.named", swiftgs.Conventions.named, [5], "conventions is 5"),
        ("Clip.box", swiftgs.Clip.box, ["x", (1, 1, 1)], "low is 'x'"),
        ("Clip.sphere", lambda *given: place(clip=swiftgs.Clip.sphere(*given)), [(0, 0, 0), "x"], "radius is 'x'"),
        ("Clip.sphere", lambda *given: place(clip=swiftgs.Clip.sphere(*given)), [(0, 0, 0), 0],
         "radius is 0, expected more"),
        ("Clip.sphere", lambda *given: place(clip=swiftgs.Clip.sphere(*given)), [(0, 0), 1],
         "centre has the shape (2,), expected (3,)"),
        ("Clip", lambda given: place(clip=swiftgs.Clip(given)), [5], "half_spaces is 5"),
        ("Clip", lambda given: place(clip=swiftgs.Clip(given)), [np.ones((7, 4))],
         "half_spaces are 7, expected 6 at most"),
        ("Clip", lambda given: place(clip=swiftgs.Clip(given)), [[[1, 2, 3]]],
         "half_spaces has the shape (1, 3), expected (1, 4)"),
        ("RenderingModel", lambda **given: swiftgs.Scene.from_arrays(**arrays, model=swiftgs.RenderingModel(**given)),
         [{"blur": -2}], "blur is -2"),
        ("Tint", lambda **given: place(tint=swiftgs.Tint(**given)), [{"amount": 2}], "amount is 2.0, expected 0 to 1"),
        ("Tint", lambda **given: place(tint=swiftgs.Tint(**given)), [{"colour": (1, 2)}],
         "colour has the shape (2,), expected (3,)"),
        ("Tint", lambda **given: place(tint=swiftgs.Tint(**given)), [{"colour": (1, 0, -1)}],
         "colour is [1.0, 0.0, -1.0], expected 0 or more"),
        ("Placement", place, [{"scene": "x"}], "scene is 'x'"),
        ("Placement", place, [{"scene": -1}], "scene is -1, expected 0 or more"),
        ("Placement", place, [{"opacity": "x"}], "opacity is 'x'"),
        ("Placement", place, [{"opacity": np.nan}], "opacity is nan, expected 0 to 1"),
        ("Placement", place, [{"first": 1 << 64}], "first is 18446744073709551616, expected 0 to"),
        ("Placement", place, [{"count": 0}], "count is 0, expected 1 or more"),
        ("Placement", place, [{"tint": (1, 0, 0)}], "tint is of type tuple, expected swiftgs.Tint"),
        ("Placement", place, [{"clip": (1, 2)}], "clip is of type tuple, expected swiftgs.Clip"),
        ("Placement", place, [{"world_from_scene": "here"}], "world_from_scene is 'here', expected numbers"),
        ("Placement", place, [{"world_from_scene": np.eye(3)}], "world_from_scene has the shape (3, 3), expected"),
        ("Placement", place, [{"world_from_scene": np.nan * view}], "expected finite numbers"),
        ("Placement", place, [{"world_from_scene": row}], "has the last row [1.0, 0.0, 0.0, 1.0], expected"),
        ("Placement", place, [{"world_from_scene": shear}], "stretches scenes by 0.78"),
        ("Placement", place, [{"world_from_scene": mirror}], "world_from_scene mirrors scenes, expected"),
        ("Frame", swiftgs.Frame, [], "a frame without planes, expected one of colour, alpha, depth, squared_depth"),
        ("Frame", swiftgs.Frame, [[[0, 0, 0]]], "colour is of type list, expected an array"),
        ("Frame", swiftgs.Frame, [zeros(4, 4, 3, kind="f8")], "of type f8, expected ([C,] H, W, 3) of f4"),
        ("Frame", swiftgs.Frame, [zeros(4, 4, 3, kind="f2")], "([C,] H, W, 4) of f4, f2 or u1"),
        ("Frame", swiftgs.Frame, [zeros(0, 4, 3)], "expected no side of 0"),
        ("Frame", swiftgs.Frame, [zeros(4, 8, 3)[:, ::2]], "pixels of a row side by side"),
        ("Frame", swiftgs.Frame, [np.broadcast_to(np.float32(0), (4, 4, 3))], "colour is read-only"),
        ("Frame", swiftgs.Frame, [strided(zeros(4, 4, 3), (2, 4, 4, 3), (0, 48, 12, 4))],
         "colour has its 2 images in one place, expected a place for each"),
        ("Frame", swiftgs.Frame, [zeros(193, kind="u1")[1:].view(np.float32).reshape(4, 4, 3)],
         "expected multiples of 4"),
        ("Frame", swiftgs.Frame, [zeros(4, 4, 3), zeros(4, 5)],
         "alpha has images of the shape (4, 5), expected (4, 4)"),
        ("Frame", swiftgs.Frame, [{"normal": zeros(4, 4)}],
         "normal has the shape (4, 4) of type f4, expected ([C,] H, W, 3) of f4"),
        ("Frame", swiftgs.Frame, [{"id": zeros(4, 4)}],
         "id has the shape (4, 4) of type f4, expected ([C,] H, W) or ([C,] H, W, 1) of u4"),
        ("Frame", swiftgs.Frame, [{"features": zeros(4, 4)}],
         "features has the shape (4, 4) of type f4, expected ([C,] H, W, F) of f4"),
        ("Frame", swiftgs.Frame, [frame.colour, {"background": "x"}], "background is 'x'"),
        ("Frame", swiftgs.Frame, [frame.colour, {"background": (0, 0)}], "background has the shape (2,)"),
        ("Frame", swiftgs.Frame, [frame.colour, {"shows": 5}], "shows is 5"),
        ("Frame", swiftgs.Frame, [pair.colour, {"shows": range(1, 1)}],
         "shows has range(1, 1), expected None or a range of one placed scene or more"),
        ("Frame", swiftgs.Frame, [pair.colour, {"shows": range(0, 4, 2)}], "shows has range(0, 4, 2)"),
        ("Frame", swiftgs.Frame, [pair.colour, {"shows": [range(1)] * 3}],
         "shows has 3 ranges, expected one, or 2, one an image"),
        ("Frame", swiftgs.Frame, [frame.colour, {"first_pixel": 5}], "first_pixel is 5"),
        ("Frame", swiftgs.Frame, [frame.colour, {"first_pixel": (0, 0.5)}], "(0, 0.5), expected two whole numbers"),
        ("Frame", swiftgs.Frame, [frame.colour, {"first_pixel": (1 << 40, 0)}], "left is 1099511627776"),
        ("Frame", swiftgs.Frame, [frame.colour, {"conventions": 5}], "conventions are of type int"),
        ("Frame", swiftgs.Frame, [frame.colour, {"conventions": swiftgs.Conventions(blur="x")}], "blur is 'x'"),
        ("Frame", swiftgs.Frame, [frame.colour, {"conventions": swiftgs.Conventions(blur=[1])}], "blur is [1]"),
        ("Frame", swiftgs.Frame, [frame.colour, {"conversion": [1]}], "conversion is [1]"),
        ("Frame", swiftgs.Frame, [frame.colour, {"stored_depth": 5}], "stored_depth is of type int"),
        ("Frame.empty", swiftgs.Frame.empty, [-4, 4], "width is -4, expected 1 or more"),
        ("Frame.empty", swiftgs.Frame.empty, [4, "x"], "height is 'x'"),
        ("Frame.empty", swiftgs.Frame.empty, [4, 4, {"format": "bgr"}], "format is 'bgr', expected one of rgb, rgba"),
        ("Frame.empty", swiftgs.Frame.empty, [4, 4, -1], "count is -1, expected 1 or more"),
        ("Frame.empty", swiftgs.Frame.empty, [4, 4, {"features": -1}], "features is -1, expected 0 or more"),
        ("Frame.save", frame.save, [5], "path is 5"), ("Frame.save", frame.save, ["a.png", "x"], "index is 'x'"),
        ("Frame.save", frame.save, ["a.png", 1], "index is 1, expected -1 to 0"),
        ("Frame.save", frame.save, ["a.gif"], "a.gif"),
        ("Frame.save", pair.save, ["a.png"],
         "save: index is None in a frame of 2 images, expected one from 0 to 1, such as "
         "'a_0.png' with index 0 up to 'a_1.png' with index 1"),
        ("Frame.save", swiftgs.Frame(alpha=zeros(4, 4)).save, ["a.png"], "expected a frame on the host with colour"),
        ("Renderer", swiftgs.Renderer, [5], "renderer is 5"),
        ("Renderer", swiftgs.Renderer, ["cpu", {"threads": -1}], "threads is -1, expected 1 or more, or 0 for all"),
        ("Renderer", swiftgs.Renderer, ["cpu", {"threads": "x"}], "threads is 'x'"),
        ("Renderer", swiftgs.Renderer, ["cpu", {"threads": HUGE}], "threads is 1180591620717411303424"),
        ("Renderer", swiftgs.Renderer, ["cpu", {"harmonics": "double"}], "expected one of float, smallest, half"),
        ("Renderer", swiftgs.Renderer, ["cpu", {"stream": "a"}], "stream is of type str"),
        ("Renderer", swiftgs.Renderer, ["cpu", {"stream": -5}], "stream is -5, expected 0 or more"),
        ("Renderer", swiftgs.Renderer, ["cpu", {"scene": 5}], "scene is of type int"),
        ("Renderer.set_scene", renderer.set_scene, [5], "scene is of type int"),
        ("Renderer.add_scene", renderer.add_scene, [5], "scene is of type int"),
        ("Renderer.place", renderer.place, [5], "placements is 5"),
        ("Renderer.place", renderer.place, [[]], "place: expected one placement or more"),
        ("Renderer.place", renderer.place, [[view]], "placement 0 is of type ndarray, expected swiftgs.Placement"),
        ("Renderer.placed_scene_of", renderer.placed_scene_of, [["x"]], "numbers are of type"),
        ("Renderer.placed_scene_of", renderer.placed_scene_of, [[[1], [1, 2]]], "numbers is [[1], [1, 2]]"),
        ("Renderer.placed_scene_of", renderer.placed_scene_of, [2000],
         "numbers have 2000, expected less than 2000 or NOTHING"),
        ("Renderer.placed_scene_of", renderer.placed_scene_of, [[3, -1]], "numbers have -1, expected"),
        ("Renderer.placed_scene_of", renderer.placed_scene_of, [[0.5]],
         "numbers are of type float64, expected whole numbers"),
        ("open_pages", swiftgs.open_pages, [5], "path is 5"), ("Pages", swiftgs.Pages, ["none.sgp"], "none.sgp"),
        ("PagePool", swiftgs.PagePool, [5, []], "renderer is of type int"),
        ("PagePool", swiftgs.PagePool, [renderer, 5], "pages is 5"),
        ("PagePool", swiftgs.PagePool, [renderer, [], {"bytes": "x"}], "bytes is 'x'"),
        ("PagePool", swiftgs.PagePool, [renderer, [], {"waiting": -1}], "waiting is -1, expected 0 or more"),
        ("PagePool.place", pool.place, [5], "placements is 5"),
        ("PagePool.cut", pool.cut, [5], "cameras is 5"),
        ("PagePool.cut", pool.cut, [camera, {"pixels": "x"}], "pixels is 'x'"),
        ("PagePool.cut", pool.cut, [camera, {"pixels": -1}], "pixels is -1, expected 0 or more"),
        ("PagePool.cut", pool.cut, [camera, {"splats": -1}], "splats is -1, expected 0 or more"),
        ("PagePool.cut", pool.cut, [camera, {"out": 5}], "out is of type int"),
        ("PagePool.cut", pool.cut, [camera, {"ahead": 5}], "cameras is 5"),
        ("PagePool.named", pool.named, [-1], "number is -1"),
        ("Renderer.share_scene", renderer.share_scene, [5], "other is of type int"),
        ("Renderer.set_gaussians", renderer.set_gaussians, of(opacities=5), "opacities is of type int"),
        ("Renderer.update_scene", renderer.update_scene, [-1], "scene is -1, expected 0 or more"),
        ("Renderer.update_scene", renderer.update_scene, [0, "x"], "first is 'x'"),
        ("Renderer.update_scene", renderer.update_scene, [0, 0], "all arrays are None, expected one or more"),
        ("Renderer.update_scene", renderer.update_scene, [0, 0, {"means": zeros(5, 3), "opacities": zeros(4)}],
         "opacities has the shape (4,), expected (5)"),
        ("Renderer.update_scene", renderer.update_scene, [0, 0, {"sh0": zeros(5, 3), "colours": zeros(5, 3)}],
         "takes either sh0 or colours"),
        ("Renderer.update_scene", renderer.update_scene, [0, 0, {"sh0": zeros(5, 3), "features": zeros(4, 3)}],
         "features has the shape (4, 3), expected (5, N)"),
        ("Renderer.render", renderer.render, [5], "cameras is 5"),
        ("Renderer.render", renderer.render, [camera, {"features": -1}], "features is -1"),
        ("Renderer.render", renderer.render, [[]], "there is no camera"),
        ("Renderer.render", renderer.render, [["a"]], "camera 0 is of type str"),
        ("Renderer.render", renderer.render, [[camera, small]], "camera 1 has 16x16 pixels, expected 80x48"),
        ("Renderer.render", renderer.render, [[camera], {"out": pair}], "1 cameras for a frame of 2 images"),
        ("Renderer.render", renderer.render, [camera, {"out": swiftgs.Frame.empty(40, 20)}],
         "the camera has 80x48 pixels and the frame 40x20, expected as many, or first_pixel for a part"),
        ("Renderer.render", renderer.render, [camera, {"out": pair, "alpha": True}], "either out or alpha"),
        ("Renderer.render", renderer.render, [camera, {"over": True}], "a new frame holds no colour to draw over"),
        ("Renderer.render", renderer.render, [camera, {"conversion": "gamma"}],
         "conversion is 'gamma', expected one of None, srgb-to-linear, "),
        ("Renderer.render", renderer.render, [camera, {"out": 5}], "out is of type int"),
        ("Renderer.render", renderer.render, [camera, {"format": 5}], "format is 5"),
        ("Renderer.reserve", renderer.reserve, [camera, 5], "out is of type int"),
        ("Renderer.reserve", renderer.reserve, [camera, frame, {"splats": -1}], "splats is -1"),
        ("Renderer.reserve", renderer.reserve, [camera, frame, {"intersections": 1.5}], "intersections is 1.5"),
        ("Renderer.set_views", reserved.set_views, [camera, 5], "out is of type int"),
        ("Renderer.record", recorded.record, [], "record: nothing was reserved"),
        ("Renderer.set_recorded_scenes", recorded.set_recorded_scenes, [], "reserve"),
        ("Renderer.recorded_scenes", lambda: recorded.recorded_scenes, [],
         "recorded_scenes: expected reserve of placed"),
        ("Renderer.visible_by_scene", lambda: recorded.visible_by_scene, [],
         "visible_by_scene: expected a frame before"),
        ("Renderer.report", lambda: reserved.report, [], "report: nothing was recorded"),
        ("Renderer.pick", drawn.pick, ["x", 0], "x is 'x'"),
        ("Renderer.pick", drawn.pick, [1 << 32, 0], "pick: x is 4294967296, expected -2147483648 to"),
        ("Renderer.pick_rectangle", drawn.pick_rectangle, [0, 0, -1, 1], "-1"),
        ("Renderer.pick_rectangle", drawn.pick_rectangle, [0, 0, 1, 1, {"view": -1}], "view is -1"),
        ("DeviceArray", swiftgs.DeviceArray, [5], "shape is 5"),
        ("DeviceArray", swiftgs.DeviceArray, [(-3,)], "shape is -3, expected 0 or more"),
        ("DeviceArray", swiftgs.DeviceArray, [(3,), -1], "device is -1, expected 0 or more"),
        ("rasterization", swiftgs.rasterization, [{**gsplat, "width": "x"}], "width is 'x'"),
        ("rasterization", swiftgs.rasterization, [{**gsplat, "width": -4}], "width is -4, expected 1 or more"),
        ("rasterization", swiftgs.rasterization, [{**gsplat, "height": HUGE}], "height is"),
        ("rasterization", swiftgs.rasterization, [{**gsplat, "near_plane": "x"}], "near_plane is 'x'"),
        ("rasterization", swiftgs.rasterization, [{**gsplat, "sh_degree": "x"}], "sh_degree is 'x'"),
        ("rasterization", swiftgs.rasterization, [{**gsplat, "sh_degree": -1}], "sh_degree is -1"),
        ("rasterization", swiftgs.rasterization, [{**gsplat, "camera_model": [1]}], "camera_model is [1]"),
        ("rasterization", swiftgs.rasterization, [{**gsplat, "means": [[0, 0, 0]]}], "means is of type list"),
        ("rasterization", swiftgs.rasterization, [{**gsplat, "viewmats": "x"}], "viewmats is of type str"),
        ("rasterization", swiftgs.rasterization, [{**gsplat, "viewmats": [["x"]]}], "viewmats is [['x']]"),
        ("rasterization", swiftgs.rasterization, [{**gsplat, "renderer": 5}], "renderer is of type int"),
    ]


@pytest.fixture
def all_refusals(scene, camera, renderer, arrays, gsplat_arguments, tmp_path):
    (tmp_path / "a.splat").write_bytes(bytes(32))
    return refusals(scene, camera, renderer, renderer.render(camera), arrays, gsplat_arguments, tmp_path / "a.splat")


def test_each_function_refuses_in_one_line_and_changes_nothing(all_refusals, renderer, camera, expected):
    wrong = []
    for name, call, arguments, words in all_refusals:
        named = arguments[-1] if arguments and isinstance(arguments[-1], dict) else {}
        try:
            call(*arguments[:len(arguments) - bool(named)], **named)
            wrong.append((name, words, "was taken"))
        except swiftgs.Error as error:
            if words not in str(error) or "\n" in str(error):
                wrong.append((name, words, str(error)))
        except Exception as error:  # pylint: disable=broad-except
            wrong.append((name, words, repr(error)))
    assert not wrong, "\n".join(map(str, wrong))
    assert np.array_equal(renderer.render(camera).colour, expected.colour)


@pytest.mark.parametrize("what, member, value, message", [case[1:] for case in listed("refusals.inc", 4)])
def test_numbers_that_no_interface_takes_are_refused(what, member, value, message, renderer, camera):
    usual = {name: getattr(camera, name) for name in ("width", "height", "fx", "fy", "cx", "cy")}
    take = {"conventions": lambda given: renderer.render(camera, conventions=swiftgs.Conventions(**given)),
            "camera": lambda given: swiftgs.Camera(**{**usual, **given}),
            "placement": lambda given: renderer.place([swiftgs.Placement(**given)])}[what]
    with pytest.raises(swiftgs.InvalidArgument, match=re.escape(message)):
        take({member: value})


def public_functions():
    """Those with arguments, of the package and of its classes. Python makes the constructors of tuples."""
    for name in swiftgs.__all__:
        found = getattr(swiftgs, name)
        if isinstance(found, types.FunctionType):
            yield name, found
        elif isinstance(found, type) and not issubclass(found, (Exception, list)):
            if not issubclass(found, tuple):
                yield name, found.__init__
            for method, function in vars(found).items():
                if not method.startswith("_") and isinstance(function, (types.FunctionType, classmethod)):
                    yield f"{name}.{method}", getattr(function, "__func__", function)


def test_no_function_is_left_out(all_refusals):
    # Arrays of the library's own making, and presets of plain numbers, which frames check.
    left = {"LentArray", "Scene", "Conventions"}
    functions = {name for name, function in public_functions()
                 if len(inspect.signature(function).parameters) > (0 if name in dir(swiftgs) and name.islower() else 1)}
    assert functions - {name for name, *_ in all_refusals} == left


def test_what_is_closed_is_refused(scene, camera):
    renderer = swiftgs.Renderer("cpu", scene=scene)
    renderer.close()
    with pytest.raises(swiftgs.OrderError, match="the renderer is closed"):
        renderer.render(camera)
    own = swiftgs.Scene.builtin(10)
    own.close()
    with pytest.raises(swiftgs.OrderError, match="the scene is closed"):
        own.save("a.ply")


def test_results_of_gsplat_that_are_not_kept_are_refused(gsplat_arguments):
    _, _, meta = swiftgs.rasterization(**gsplat_arguments)
    with pytest.raises(swiftgs.NoSuchResult) as raised:
        meta["radii"]  # pylint: disable=pointless-statement
    assert str(raised.value).startswith("meta has no 'radii', expected one of width, ")
    assert (meta["width"], meta["height"]) == (WIDTH, HEIGHT)
