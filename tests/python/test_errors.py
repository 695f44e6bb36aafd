# SPDX-License-Identifier: Apache-2.0
"""Every refusal is a `swiftgs.Error`, in one line that names what was given."""
import ast
import inspect
import pathlib
import types

import numpy as np
import pytest

import swiftgs
from conftest import HEIGHT, WIDTH
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


def refusals(scene, camera, renderer, frame, arrays, gsplat, at):
    """(what is called, arguments that it refuses, words of the message)."""
    view = np.eye(4)
    orbit = swiftgs.OrbitView(camera, (0, 0, 0))
    cls, placement = swiftgs.Camera, swiftgs.Placement
    of = lambda **changed: [{**arrays, **changed}]  # noqa: E731
    recorded, reserved = (swiftgs.Renderer("cpu", scene=scene) for _ in range(2))
    reserved.reserve(camera, frame)
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
        ("Scene.from_arrays", swiftgs.Scene.from_arrays, of(model="x"), "model is of type str"),
        ("Scene.from_arrays", swiftgs.Scene.from_arrays, of(model=swiftgs.RenderingModel(order="z")), "order is 'z'"),
        ("Scene.from_bytes", swiftgs.Scene.from_bytes, [BAD, "a.ply"], "data is of type object"),
        ("Scene.from_bytes", swiftgs.Scene.from_bytes, [b"", "a.ply"], "a.ply"),
        ("Scene.from_bytes", swiftgs.Scene.from_bytes, [b"1", 5], "path is 5"),
        ("Scene.save", scene.save, [5], "path is 5"), ("Scene.save", scene.save, ["a", {"format": 5}], "format is 5"),
        ("Scene.save", scene.save, ["a.spz", {"spz_version": "x"}], "spz_version is 'x'"),
        ("Scene.save", scene.save, ["a.spz", {"spz_version": -1}], "-1"),
        ("Scene.save", scene.save, ["a.spz", {"progress": "x"}], "progress is 'x'"),
        ("Scene.default_view", scene.default_view, ["x"], "width is 'x'"),
        ("Scene.default_view", scene.default_view, [HUGE], "width is 1180591620717411303424"),
        ("Scene.default_view", scene.default_view, [-4, 4], "-4"),
        ("Scene.default_view", scene.default_view, [{"up": "x"}], "up is 'x'"),
        ("Camera", cls, ["x", 4, 1], "width is 'x'"),
        ("Camera", cls, [np.int64(1 << 40), 4, 1], "width is 1099511627776"),
        ("Camera", cls, [4, 4, "x"], "fx is 'x'"), ("Camera", cls, [4, 4, 1, {"rotation": "x"}], "rotation is 'x'"),
        ("Camera", cls, [4, 4, 1, {"translation": 5}], "translation has the shape ()"),
        ("Camera", cls, [4, 4, 1, {"radial": "x"}], "radial is 'x'"),
        ("Camera", cls, [-4, 4, 1], "a width and a height above 0"),
        ("Camera.from_matrices", cls.from_matrices, ["x", view, 4, 4], "viewmat is 'x'"),
        ("Camera.from_projection", cls.from_projection, ["x", view, 4, 4, "opengl"], "view is 'x'"),
        ("Camera.from_projection", cls.from_projection, [view, view, 4, 4, "metal"], "clip_space is 'metal'"),
        ("Camera.look_at", lambda eye: cls.look_at(eye, (0, 0, 1), width=4, height=4, vertical_fov=1), ["x"],
         "eye is 'x'"),
        ("Camera.builtin", cls.builtin, [(1 << 32) + 4, 4], "width is 4294967300"),
        ("Camera.builtin", cls.builtin, [-4, 4], "a width and a height above 0"),
        ("Camera.builtin", cls.builtin, [4, 4.5], "height is 4.5"),
        ("Camera.scaled", camera.scaled, ["x"], "scale is 'x'"),
        ("Camera.scaled", camera.scaled, [-1], "a finite scale above 0"),
        ("Camera.relative_to", camera.relative_to, [5], "origin has the shape ()"),
        ("Camera.matrices", camera.matrices, ["x", 1, "opengl"], "at_0 is 'x'"),
        ("Camera.matrices", camera.matrices, [0.1, 1, None], "clip_space is None"),
        ("OrbitView.orbit", orbit.orbit, ["x"], "turn is 'x'"),
        ("OrbitView.orbit", orbit.orbit, [1, 0, 0], "distance 0"),
        ("StoredDepth.perspective", swiftgs.StoredDepth.perspective, ["x", 1], "at_0 is 'x'"),
        ("StoredDepth.orthographic", swiftgs.StoredDepth.orthographic, [0, "x"], "at_1 is 'x'"),
        ("Conventions.named", swiftgs.Conventions.named, [5], "conventions is 5"),
        ("Conventions.named", swiftgs.Conventions.named, ["other"], "other"),
        ("Clip.box", swiftgs.Clip.box, ["x", (1, 1, 1)], "low is 'x'"),
        ("Clip.sphere", lambda *given: renderer.place([placement(clip=swiftgs.Clip.sphere(*given))]), [(0, 0, 0), "x"],
         "radius is 'x'"),
        ("Clip", lambda given: renderer.place([placement(clip=swiftgs.Clip(given))]), [5], "half_spaces is 5"),
        ("RenderingModel", lambda **given: swiftgs.Scene.from_arrays(**arrays, model=swiftgs.RenderingModel(**given)),
         [{"blur": -2}], "blur is -2"),
        ("Tint", lambda **given: renderer.place([placement(tint=swiftgs.Tint(**given))]), [{"amount": 2}],
         "amount is 2"),
        ("Placement", lambda **given: renderer.place([placement(**given)]), [{"scene": "x"}], "scene is 'x'"),
        ("Placement", lambda **given: renderer.place([placement(**given)]), [{"opacity": "x"}], "opacity is 'x'"),
        ("Placement", lambda **given: renderer.place([placement(**given)]), [{"count": -1}], "count is -1"),
        ("Frame", swiftgs.Frame, [], "a frame without planes"),
        ("Frame", swiftgs.Frame, [frame.colour, {"background": "x"}], "background is 'x'"),
        ("Frame", swiftgs.Frame, [frame.colour, {"shows": 5}], "shows is 5"),
        ("Frame", swiftgs.Frame, [frame.colour, {"first_pixel": 5}], "first_pixel is 5"),
        ("Frame", swiftgs.Frame, [frame.colour, {"conventions": 5}], "conventions are of type int"),
        ("Frame", swiftgs.Frame, [frame.colour, {"conventions": swiftgs.Conventions(blur="x")}], "blur is 'x'"),
        ("Frame", swiftgs.Frame, [frame.colour, {"conventions": swiftgs.Conventions(blur=[1])}], "blur is [1]"),
        ("Frame", swiftgs.Frame, [frame.colour, {"conversion": [1]}], "conversion is [1]"),
        ("Frame", swiftgs.Frame, [frame.colour, {"stored_depth": 5}], "stored_depth is of type int"),
        ("Frame.empty", swiftgs.Frame.empty, [-4, 4], "width is -4, expected 1 or more"),
        ("Frame.empty", swiftgs.Frame.empty, [4, "x"], "height is 'x'"),
        ("Frame.empty", swiftgs.Frame.empty, [4, 4, -1], "count is -1, expected 1 or more"),
        ("Frame.empty", swiftgs.Frame.empty, [4, 4, {"features": -1}], "features is -1, expected 0 or more"),
        ("Frame.save", frame.save, [5], "path is 5"), ("Frame.save", frame.save, ["a.png", "x"], "index is 'x'"),
        ("Frame.save", frame.save, ["a.png", 1], "index is 1, expected -1 to 0"),
        ("Renderer", swiftgs.Renderer, [5], "renderer is 5"),
        ("Renderer", swiftgs.Renderer, ["cpu", {"threads": -1}], "threads is -1, expected 1 or more, or 0 for all"),
        ("Renderer", swiftgs.Renderer, ["serial", {"threads": -1}], "threads is -1"),
        ("Renderer", swiftgs.Renderer, ["cpu", {"threads": "x"}], "threads is 'x'"),
        ("Renderer", swiftgs.Renderer, ["cpu", {"threads": HUGE}], "threads is 1180591620717411303424"),
        ("Renderer", swiftgs.Renderer, ["cpu", {"harmonics": 5}], "harmonics is 5"),
        ("Renderer", swiftgs.Renderer, ["cpu", {"stream": -5}], "stream is -5, expected 0 or more"),
        ("Renderer", swiftgs.Renderer, ["cpu", {"scene": 5}], "scene is of type int"),
        ("Renderer.set_scene", renderer.set_scene, [5], "scene is of type int"),
        ("Renderer.add_scene", renderer.add_scene, [5], "scene is of type int"),
        ("Renderer.place", renderer.place, [5], "placements is 5"), ("Renderer.place", renderer.place, [[]], "place"),
        ("Renderer.placed_scene_of", renderer.placed_scene_of, [["x"]], "numbers are of type"),
        ("Renderer.placed_scene_of", renderer.placed_scene_of, [[[1], [1, 2]]], "numbers is [[1], [1, 2]]"),
        ("Renderer.share_scene", renderer.share_scene, [5], "other is of type int"),
        ("Renderer.set_gaussians", renderer.set_gaussians, of(opacities=5), "opacities is of type int"),
        ("Renderer.update_scene", renderer.update_scene, [-1], "scene is -1, expected 0 or more"),
        ("Renderer.update_scene", renderer.update_scene, [0, "x"], "first is 'x'"),
        ("Renderer.render", renderer.render, [5], "cameras is 5"),
        ("Renderer.render", renderer.render, [camera, {"features": -1}], "features is -1"),
        ("Renderer.render", renderer.render, [camera, {"out": 5}], "out is of type int"),
        ("Renderer.render", renderer.render, [camera, {"format": 5}], "format is 5"),
        ("Renderer.reserve", renderer.reserve, [camera, 5], "out is of type int"),
        ("Renderer.reserve", renderer.reserve, [camera, frame, {"splats": -1}], "splats is -1"),
        ("Renderer.reserve", renderer.reserve, [camera, frame, {"intersections": 1.5}], "intersections is 1.5"),
        ("Renderer.set_views", reserved.set_views, [camera, 5], "out is of type int"),
        ("Renderer.set_views", recorded.set_views, [camera, frame], "set_views: nothing was reserved"),
        ("Renderer.record", recorded.record, [], "record: nothing was reserved"),
        ("Renderer.set_recorded_scenes", recorded.set_recorded_scenes, [], "reserve"),
        ("Renderer.pick", renderer.pick, ["x", 0], "x is 'x'"), ("Renderer.pick", renderer.pick, [-1, 0], "-1"),
        ("Renderer.pick_rectangle", renderer.pick_rectangle, [0, 0, -1, 1], "-1"),
        ("Renderer.pick_rectangle", renderer.pick_rectangle, [0, 0, 1, 1, {"view": -1}], "view is -1"),
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


def test_each_function_refuses_in_one_line(all_refusals):
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
