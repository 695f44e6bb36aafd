# SPDX-License-Identifier: Apache-2.0
"""Frames on the host."""
import dataclasses
import gc
import math
import os
import re
import subprocess
import threading
import time
import weakref

import numpy as np
import pytest

import swiftgs
from conftest import HEIGHT, WIDTH, Lent, arrays_of, decibels, has_device, seen_from, side_by_side
from swiftgs._planes import PLANES


def test_the_table_has_every_renderer_and_names_the_usual_one():
    table = swiftgs.list_renderers()
    assert len(table) > 50 and all(entry.name.count("/") == 3 for entry in table)
    usable = {entry.name.split("/")[0] for entry in table if entry.usable}
    best = swiftgs.Renderer().name
    assert best.split("/")[0] == ("cuda" if "cuda" in usable else "cpu")
    assert swiftgs.Renderer("serial").name == best.replace(best.split("/")[0], "serial")
    assert swiftgs.find_renderer().name == best and swiftgs.find_renderer(best).name == best
    assert swiftgs.find_renderer("serial") == (swiftgs.Renderer("serial").name, True, False)
    assert all(swiftgs.find_renderer(entry.name) == entry for entry in table[::20])
    assert all(entry.on_device == entry.name.startswith("cuda/") for entry in table)
    with pytest.raises(swiftgs.InvalidArgument, match="renderer 'nobody' is not known; expected a BACKEND or BACKEND/"):
        swiftgs.Renderer("nobody")


def test_lenses_and_measures_of_depth_reach_the_frame(renderer, camera, expected):
    def through(fx=camera.fx, **lens):
        return swiftgs.Camera(WIDTH, HEIGHT, fx, rotation=camera.rotation, translation=camera.translation, **lens)

    cameras = [camera, through(WIDTH / 6.4, model="fisheye"), through(WIDTH / (2 * np.pi), model="equirectangular"),
               through(radial=(-0.1,))]
    batch = renderer.render(cameras)
    for image, alone in zip(batch.colour, cameras):
        assert np.array_equal(image, renderer.render(alone).colour) and np.isfinite(image).all()
        assert alone is camera or decibels(image, expected.colour) < 30
    z = renderer.render(camera, depth=True, conventions=swiftgs.Conventions(depth="z"))
    distance = renderer.render(camera, depth=True, conventions=swiftgs.Conventions(depth="distance"))
    assert np.array_equal(z.depth, expected.depth) and (distance.depth >= 0.999 * z.depth).mean() > 0.9
    assert distance.depth[0, 0] > z.depth[0, 0]


def test_a_renderer_tells_what_it_is(renderer):
    assert re.fullmatch(r"<swiftgs.Renderer cpu/early/\S+ on .*, 2,000 Gaussians>", repr(renderer))
    assert "thread" in renderer.device_name and not renderer.on_device
    assert "2 threads" in swiftgs.Renderer("cpu", threads=2).device_name or os.cpu_count() < 2


def test_scenes_are_uploaded_with_the_harmonics_that_were_asked_for(scene, camera):
    images = [swiftgs.Renderer("cpu", scene=scene, harmonics=kept).render(camera).colour
              for kept in ("smallest", "float", "half")]
    assert np.array_equal(images[0], images[1]) and not np.array_equal(images[1], images[2])
    assert np.abs(images[1] - images[2]).max() < 1e-2


def test_images_are_those_of_the_command_line_tool(tmp_path):
    tool = os.environ.get("SWIFTGS_TOOL")
    if not tool:
        pytest.skip("SWIFTGS_TOOL does not name the tool")
    renderer = swiftgs.Renderer("cpu", scene=swiftgs.Scene.builtin(3000))
    subprocess.run([tool, "render", "builtin:3000", "--scale", "0.1", "--format", "pfm", "--out", tmp_path,
                    "--renderer", renderer.name], check=True, stdout=subprocess.DEVNULL)
    header, size, scale, pixels = next(tmp_path.glob("*.pfm")).read_bytes().split(b"\n", 3)
    width, height = map(int, size.split())
    assert header == b"PF" and float(scale) < 0
    image = np.frombuffer(pixels, "<f4").reshape(height, width, 3)[::-1]
    assert np.array_equal(renderer.render(swiftgs.Camera.builtin(width, height)).colour, image)


def test_all_formats_show_the_same_image(renderer, camera, expected):
    assert expected.colour.shape == (HEIGHT, WIDTH, 3) and expected.alpha.shape == (HEIGHT, WIDTH)
    assert expected.colour.std() > 0.05 and expected.alpha.max() > 0.9 and expected.depth.max() > 1
    rgba = renderer.render(camera, format="rgba").colour
    assert np.array_equal(rgba[..., :3], expected.colour) and np.array_equal(rgba[..., 3], expected.alpha)
    half = renderer.render(camera, format="rgba-half").colour
    assert half.dtype == np.float16 and np.array_equal(half, rgba.astype(np.float16))
    bytes_ = renderer.render(camera, format="rgba8").colour
    assert bytes_.dtype == np.uint8 and np.array_equal(bytes_, np.floor(np.clip(rgba, 0, 1) * 255 + 0.5))
    only = renderer.render(camera, colour=False, depth=True)
    assert only.colour is None and only.alpha is None and np.array_equal(only.depth, expected.depth)


@pytest.fixture(scope="module")
def featured(scene):
    """A renderer whose Gaussians have two features: 1, and a whole number of its own."""
    features = np.stack([np.ones(len(scene)), np.arange(len(scene)) % 7 - 3], axis=1).astype(np.float32)
    return swiftgs.Renderer("serial", scene=swiftgs.Scene.from_arrays(**arrays_of(scene), any_rotations=False,
                                                                      features=features))


ALL_PLANES = {**{name: True for name in PLANES}, "features": 2}


def test_planes_tell_of_each_pixel(featured, camera):
    frame = featured.render(camera, **ALL_PLANES)
    assert np.array_equal(frame.colour, featured.render(camera).colour)
    for name in ("alpha", "depth", "squared_depth", "first_depth", "median_depth"):
        assert getattr(frame, name).shape == (HEIGHT, WIDTH) and getattr(frame, name).dtype == np.float32, name
    assert frame.normal.shape == (HEIGHT, WIDTH, 3) and frame.features.shape == (HEIGHT, WIDTH, 2)
    assert frame.id.shape == frame.median_id.shape == (HEIGHT, WIDTH) and frame.id.dtype == np.uint32
    assert np.all(frame.squared_depth >= 0.9999 * frame.depth ** 2)
    assert np.array_equal(frame.median_depth > 0, frame.alpha > 0.5)
    both = frame.median_depth > 0
    assert both.any() and np.all(frame.first_depth[both] <= frame.median_depth[both])
    assert np.array_equal(frame.median_id == swiftgs.NOTHING, ~both)
    assert np.array_equal(frame.id == swiftgs.NOTHING, frame.alpha == 0) and (frame.id != frame.median_id).any()
    assert np.abs(frame.normal).max() > 0.5
    later = featured.render(camera, first_depth=True, conventions=swiftgs.Conventions(first_alpha=0.5))
    assert not np.array_equal(later.first_depth, frame.first_depth)
    assert np.allclose(frame.features[..., 0], frame.alpha, atol=1e-5) and frame.features[..., 1].std() > 0.1
    picked = featured.pick_rectangle(30, 20, 9, 7)
    assert np.array_equal(picked["gaussian"], frame.id[20:27, 30:39])
    assert np.array_equal(picked["median"], frame.median_id[20:27, 30:39])
    with pytest.raises(swiftgs.InvalidArgument, match="asks for 3 features a Gaussian, expected at most the 2"):
        featured.render(camera, features=3)


def test_planes_go_to_arrays_of_any_layout(featured, camera):
    wanted = featured.render(camera, **ALL_PLANES)
    normal = np.zeros((2, HEIGHT, 2 * WIDTH, 3), np.float32)[:, ::-1, WIDTH:]
    ids = np.zeros((2, HEIGHT, WIDTH, 1), np.uint32)
    features = np.zeros((2, HEIGHT, WIDTH, 1), np.float32)
    out = featured.render([camera, camera], out=swiftgs.Frame(normal=normal, id=ids, features=features))
    assert out.colour is None and out.normal is normal
    assert np.array_equal(normal[1], wanted.normal) and np.array_equal(ids[1, ..., 0], wanted.id)
    assert np.array_equal(features[0, ..., 0], wanted.features[..., 0])


def test_batches_have_the_bits_of_single_frames(renderer, camera, expected):
    other = seen_from(1, -2, -4)
    frame = renderer.render([camera, other, camera], alpha=True)
    assert frame.colour.shape == (3, HEIGHT, WIDTH, 3) and frame.alpha.shape == (3, HEIGHT, WIDTH) and len(frame) == 3
    assert np.array_equal(frame.colour[0], expected.colour) and np.array_equal(frame.colour[2], expected.colour)
    assert np.array_equal(frame.colour[1], renderer.render(other).colour)
    assert np.array_equal(renderer.render((camera,)).colour, expected.colour[None])
    colours = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
    frame = renderer.render([camera, camera, camera], background=colours)
    for image, background in zip(frame.colour, colours):
        assert np.array_equal(image, renderer.render(camera, background=background).colour)


@pytest.mark.parametrize("place", [
    lambda: np.zeros((HEIGHT, WIDTH, 3), np.float32)[::-1],
    lambda: np.zeros((HEIGHT, WIDTH + 7, 3), np.float32)[:, 3:-4],
    lambda: np.zeros((2 * HEIGHT, WIDTH, 3), np.float32)[1::2],
    lambda: np.zeros((1, HEIGHT, WIDTH, 3), np.float32),
    lambda: np.zeros((5, HEIGHT, 2 * WIDTH, 3), np.float32)[1:5:2, :, WIDTH:]])
def test_memory_with_gaps_and_rows_that_go_up(place, renderer, camera, expected):
    colour = place()
    out = swiftgs.Frame(colour)
    assert renderer.render([camera] * len(out) if out.batched else camera, out=out) is out and out.colour is colour
    assert all(np.array_equal(image, expected.colour) for image in colour.reshape(-1, HEIGHT, WIDTH, 3))
    base = colour.base if colour.base is not None else colour
    assert np.count_nonzero(base) == len(out) * np.count_nonzero(expected.colour)


def test_conversions_of_colours(renderer, camera):
    plain, linear, encoded = (renderer.render([camera, camera], conversion=conversion).colour
                              for conversion in (None, "srgb-to-linear", "linear-to-srgb"))
    between = (plain > 0) & (plain < 1)
    assert between.mean() > 0.5 and (linear < plain)[between].all() and (encoded > plain)[between].all()
    assert np.array_equal(linear[0], linear[1]) and np.array_equal(encoded[0], encoded[1])
    with pytest.raises(ValueError, match="conversion is 'gamma', expected one of None, srgb-to-linear, "):
        renderer.render(camera, conversion="gamma")


def test_over_and_occluder_and_first_pixel(renderer, camera, expected):
    colour = np.full((HEIGHT, WIDTH, 3), 0.25, np.float32)
    renderer.render(camera, out=swiftgs.Frame(colour, over=True))
    assert np.array_equal(colour, renderer.render(camera, background=(0.25, 0.25, 0.25)).colour)
    hidden = renderer.render(camera, occluder=np.zeros((HEIGHT, WIDTH), np.float32), alpha=True)
    assert not hidden.alpha.any()
    renderer.render(camera, occluder=np.full((HEIGHT, WIDTH), 1e-3, np.float32), counts=True)
    assert renderer.statistics.intersections_hidden == renderer.statistics.intersections > 0
    assert renderer.statistics.nearly_all_hidden
    renderer.render(camera, occluder=np.full((HEIGHT, WIDTH), np.inf, np.float32), counts=True)
    assert renderer.statistics.intersections_hidden == 0 and not renderer.statistics.nearly_all_hidden
    window_depth = np.full((HEIGHT, WIDTH), 1 - 1e-3 / 2, np.float32)  # of what stands at the depth 2
    stored = swiftgs.StoredDepth.perspective(1e-3, np.inf)
    depths = np.full((HEIGHT, WIDTH), 1 / (stored.r * np.float64(window_depth[0, 0]) + stored.s), np.float32)
    assert 1.9 < depths[0, 0] < 2.1
    before = renderer.render(camera, occluder=window_depth, stored_depth=stored).colour
    assert np.array_equal(before, renderer.render(camera, occluder=depths).colour)
    assert not np.array_equal(before, expected.colour)
    band = swiftgs.Frame(np.zeros((16, 32, 3), np.float32), first_pixel=(16, 32))
    assert np.array_equal(renderer.render(camera, out=band).colour, expected.colour[32:48, 16:48])


def test_conventions_reach_the_frame(renderer, camera, expected):
    inria = renderer.render(camera, conventions="inria").colour
    assert not np.array_equal(inria, expected.colour)
    named = swiftgs.Conventions.named("inria")
    assert np.array_equal(renderer.render(camera, conventions=named).colour, inria)


@pytest.mark.parametrize("model", [swiftgs.RenderingModel(blur=0.1, antialiased=True),
                                   swiftgs.RenderingModel(order="distance", colours="linear"),
                                   swiftgs.RenderingModel(blur=0)])
def test_scenes_are_drawn_as_they_were_trained(renderer, arrays, camera, model):
    said = swiftgs.Conventions(blur=model.blur, antialiased=model.antialiased, order=model.order, colours=model.colours)
    with swiftgs.Renderer(renderer.name, scene=swiftgs.Scene.from_arrays(**arrays)) as plain:
        usual, expected = plain.render(camera, conventions=said).colour, plain.render(camera).colour
    assert not np.array_equal(usual, expected)
    with swiftgs.Renderer(renderer.name, scene=swiftgs.Scene.from_arrays(**arrays, model=model)) as own:
        assert np.array_equal(own.render(camera).colour, usual)
        own.set_gaussians(**arrays, model=model)
        assert np.array_equal(own.render(camera).colour, usual)
        default = swiftgs.Conventions(blur=0.3, antialiased=False, order="depth", colours="srgb")
        assert np.array_equal(own.render(camera, conventions=default).colour, expected)


@pytest.mark.parametrize("make, kind, text", [
    (swiftgs.Frame, ValueError, "a frame without planes, expected one of colour, alpha, depth, squared_depth"),
    (lambda: swiftgs.Frame(normal=np.zeros((4, 4), np.float32)), ValueError,
     "normal has the shape (4, 4) of type f4, expected ([C,] H, W, 3) of f4"),
    (lambda: swiftgs.Frame(normal=np.zeros((4, 4, 2), np.float32)), ValueError, "expected ([C,] H, W, 3) of f4"),
    (lambda: swiftgs.Frame(id=np.zeros((4, 4), np.float32)), ValueError,
     "id has the shape (4, 4) of type f4, expected ([C,] H, W) or ([C,] H, W, 1) of u4"),
    (lambda: swiftgs.Frame(features=np.zeros((4, 4), np.float32)), ValueError,
     "features has the shape (4, 4) of type f4, expected ([C,] H, W, F) of f4"),
    (lambda: swiftgs.Frame(features=np.zeros((4, 4, 0), np.float32)), ValueError, "expected no side of 0"),
    (lambda: swiftgs.Frame(np.zeros((4, 4, 2), np.float32)), ValueError, "colour has the shape (4, 4, 2) of type f4"),
    (lambda: swiftgs.Frame(np.zeros((4, 4, 3))), ValueError, "of type f8, expected ([C,] H, W, 3) of f4"),
    (lambda: swiftgs.Frame(np.zeros((4, 4, 3), np.float16)), ValueError, "([C,] H, W, 4) of f4, f2 or u1"),
    (lambda: swiftgs.Frame(np.zeros((0, 4, 3), np.float32)), ValueError, "expected no side of 0"),
    (lambda: swiftgs.Frame(np.zeros((4, 8, 3), np.float32)[:, ::2]), ValueError, "pixels of a row side by side"),
    (lambda: swiftgs.Frame(np.zeros((4, 4, 6), np.float32)[..., ::2]), ValueError, "pixels of a row side by side"),
    (lambda: swiftgs.Frame(np.zeros((3, 4, 4), np.float32).transpose(1, 2, 0)), ValueError, "side by side"),
    (lambda: swiftgs.Frame(np.broadcast_to(np.float32(0), (4, 4, 3))), ValueError, "colour is read-only"),
    (lambda: swiftgs.Frame(alpha=np.zeros((4, 4))), ValueError, "alpha has the shape (4, 4) of type f8"),
    (lambda: swiftgs.Frame(np.zeros((4, 4, 3), np.float32), np.zeros((4, 5), np.float32)), ValueError,
     "alpha has images of the shape (4, 5), expected (4, 4)"),
    (lambda: swiftgs.Frame(np.lib.stride_tricks.as_strided(np.zeros((4, 4, 3), np.float32), (2, 4, 4, 3),
                                                           (0, 48, 12, 4))), ValueError,
     "colour has its 2 images in one place, expected a place for each"),
    (lambda: swiftgs.Frame(np.zeros(4 * 48 + 1, np.uint8)[1:].view(np.float32).reshape(4, 4, 3)), ValueError,
     "expected multiples of 4"),
    (lambda: swiftgs.Renderer("cpu", scene=swiftgs.Scene.builtin(10)).render(
        swiftgs.Camera.builtin(4, 4), out=swiftgs.Frame(np.lib.stride_tricks.as_strided(
            np.zeros((4, 4, 3), np.float32), (4, 4, 3), (12, 12, 4)))), ValueError, "pitch"),
    (lambda: swiftgs.Frame.empty(16, 16, first_pixel=(1 << 40, 0)), ValueError, "left is 1099511627776"),
    (lambda: swiftgs.Frame.empty(16, 16, first_pixel=(0, 0.5)), TypeError, "(0, 0.5), expected two whole numbers"),
    (lambda: swiftgs.Frame.empty(16, 16, first_pixel=(1,)), TypeError, "(1,), expected two whole numbers"),
    (lambda: swiftgs.Frame.empty(16, 16, first_pixel=5), TypeError, "first_pixel is 5, expected"),
    (lambda: swiftgs.Frame([[0, 0, 0]]), TypeError, "colour is of type list, expected an array"),
    (lambda: swiftgs.Frame.empty(4, 4, format="bgr"), ValueError, "format is 'bgr', expected one of rgb, rgba"),
    (lambda: swiftgs.Frame.empty(4, 4, background=(0, 0)), ValueError, "background has the shape (2,)"),
    (lambda: swiftgs.Frame.empty(4, 4).save("a.png", 1), ValueError, "save: index is 1, expected -1 to 0")])
def test_what_is_no_frame_is_refused(make, kind, text):
    with pytest.raises(kind, match=re.escape(text)):
        make()


def test_what_cannot_be_drawn_is_refused(renderer, camera, arrays, expected):
    frame = swiftgs.Frame.empty(WIDTH, HEIGHT, 2)
    small = swiftgs.Camera.builtin(16, 16)
    nan = arrays["means"].copy()
    nan[7, 1] = np.nan
    for call, kind, text in [
            (lambda: renderer.render(camera, out=swiftgs.Frame.empty(40, 20)), ValueError,
             "the camera has 80x48 pixels and the frame 40x20, expected as many, or first_pixel for a part"),
            (lambda: renderer.render([camera, small], out=frame), ValueError, "the camera has 16x16 pixels and the"),
            (lambda: renderer.render(camera, out="a"), TypeError, "out is of type str, expected swiftgs.Frame"),
            (lambda: renderer.set_scene("a.ply"), TypeError, "scene is of type str, expected swiftgs.Scene"),
            (lambda: renderer.share_scene(None), TypeError, "other is of type NoneType, expected swiftgs.Renderer"),
            (lambda: renderer.render([camera], out=frame), ValueError, "1 cameras for a frame of 2 images"),
            (lambda: renderer.render([camera, small]), ValueError, "camera 1 has 16x16 pixels, expected 80x48"),
            (lambda: renderer.render([]), ValueError, "there is no camera"),
            (lambda: renderer.render(["a"]), TypeError, "camera 0 is of type str"),
            (lambda: renderer.render(["a", camera], out=frame), TypeError, "camera 0 is of type str"),
            (lambda: renderer.render(camera, out=frame, alpha=True), TypeError, "either out or alpha"),
            (lambda: renderer.render(camera, out=swiftgs.Frame.empty(8, 8, first_pixel=(3, 0))), ValueError, "16"),
            (lambda: renderer.render(camera, over=True), ValueError, "a new frame holds no colour to draw over"),
            (lambda: swiftgs.Renderer("cpu").render(camera), swiftgs.OrderError, "expected a scene before"),
            (lambda: swiftgs.Renderer("cpu/a/b/c"), swiftgs.InvalidArgument, "cpu/a/b/c"),
            (lambda: swiftgs.Renderer("cpu", threads=-1), ValueError, "threads is -1, expected 1 or more, or 0 for"),
            (lambda: swiftgs.Renderer("cpu", harmonics="double"), ValueError, "expected one of float, smallest, half"),
            (lambda: swiftgs.Renderer("cpu", stream="a"), TypeError, "stream is of type str"),
            (lambda: renderer.set_gaussians(**dict(arrays, means=nan)), swiftgs.InvalidArgument, "Gaussian 7 is nan"),
            (lambda: swiftgs.Renderer("serial").share_scene(renderer), swiftgs.InvalidArgument, "another backend")]:
        with pytest.raises(kind, match=re.escape(text)):
            call()
    assert np.array_equal(renderer.render(camera).colour, expected.colour)  # usable afterwards


def test_arrays_are_drawn_as_the_scene_that_has_them(scene, camera, expected, arrays):
    renderer = swiftgs.Renderer("cpu")
    renderer.set_gaussians(**arrays, any_rotations=False)
    assert np.array_equal(renderer.render(camera).colour, expected.colour)
    renderer.set_gaussians(**{name: Lent(array.copy()) for name, array in arrays.items()})
    assert decibels(renderer.render(camera).colour, expected.colour) > 90  # rotations are normalised once more


def test_measures_are_taken_where_they_are_asked_for(renderer, camera):
    renderer.render(camera)
    assert math.isnan(renderer.times.total) and renderer.statistics.contributing_pairs == 0
    out = renderer.render(camera, times=True)
    assert renderer.times.total > 0 and renderer.statistics.contributing_pairs == 0
    renderer.render(camera, out=out)
    assert math.isnan(renderer.times.total)
    renderer.render(camera, out=out, times=True, counts=True)
    assert renderer.times.total >= renderer.times.raster > 0
    assert renderer.statistics.contributing_pairs > renderer.statistics.visible > 0
    assert renderer.memory.project > 0 and renderer.memory.device_total == 0
    renderer.trim()
    assert renderer.memory.project == 0
    renderer.wait()


def test_pixels_tell_which_gaussians_they_show(renderer, camera, scene):
    with pytest.raises(swiftgs.OrderError, match="pick: expected a frame before"):
        renderer.pick(0, 0)
    other = seen_from(1, -2, -4)
    frame = renderer.render([other, camera], alpha=True)
    x, y = WIDTH // 2, HEIGHT // 2
    middle = renderer.pick(x, y, view=1)
    assert 0 <= middle.gaussian < len(scene) and 0 < middle.weight <= frame.alpha[1, y, x]
    assert (middle.median is not None) == (frame.alpha[1, y, x] > 0.5) and middle != renderer.pick(x, y)
    depth = scene.means[middle.gaussian] @ camera.rotation[2] + camera.translation[2]
    assert middle.depth == pytest.approx(depth, rel=1e-5)

    around = renderer.pick_rectangle(x - 30, y - 12, 60, 24, view=1)
    assert around.shape == (24, 60) and around.dtype.names == swiftgs.Picked._fields
    assert around[12, 30].item()[:3] == middle[:3] and len(np.unique(around["gaussian"])) > 2
    assert (around["weight"] <= frame.alpha[1, y - 12:y + 12, x - 30:x + 30] + 1e-6).all()


def test_what_cannot_be_picked_is_refused(renderer, camera):
    renderer.render(camera)
    for call, kind, text in [
            (lambda: renderer.pick(WIDTH, 0), swiftgs.InvalidArgument, "pixels 80 to 80 along x"),
            (lambda: renderer.pick(0, -1), swiftgs.InvalidArgument, "pixels -1 to -1 along y"),
            (lambda: renderer.pick_rectangle(0, 0, 1, -1), swiftgs.InvalidArgument, "-1 pixels along y"),
            (lambda: renderer.pick(0, 0, view=-1), ValueError, "pick: view is -1, expected 0 or more"),
            (lambda: renderer.pick(1 << 32, 0), ValueError, "pick: x is 4294967296, expected -2147483648 to"),
            (lambda: renderer.pick(0.5, 0), TypeError, "pick: x is 0.5, expected a whole number")]:
        with pytest.raises(kind, match=text):
            call()
    renderer.trim()
    with pytest.raises(swiftgs.OrderError):
        renderer.pick(0, 0)


def test_images_outlive_their_renderer_and_frames_their_cameras(scene, expected):
    renderer = swiftgs.Renderer("cpu", scene=scene)
    frame = renderer.render(swiftgs.Camera.builtin(WIDTH, HEIGHT))
    colour = frame.colour
    gone = weakref.ref(frame)
    renderer.close()
    del renderer, frame
    gc.collect()
    assert gone() is None and np.array_equal(colour, expected.colour)


def test_a_frame_is_aimed_anew_by_each_call_at_cameras_that_may_go(renderer, scene, camera, expected):
    out, pair = swiftgs.Frame.empty(WIDTH, HEIGHT), swiftgs.Frame.empty(WIDTH, HEIGHT, 2)
    for step in range(6):
        wanted = renderer.render(seen_from(step, -2, -4)).colour
        renderer.render(seen_from(step, -2, -4) if step % 2 else [seen_from(step, -2, -4)], out=out)
        renderer.render((camera for camera in (seen_from(step, -2, -4), camera)), out=pair)
        made = renderer.render(camera for camera in (seen_from(step, -2, -4), camera))
        gc.collect()
        assert np.array_equal(out.colour, wanted) and np.array_equal(made.colour, pair.colour)
        assert np.array_equal(pair.colour, np.stack([wanted, expected.colour]))
        with pytest.raises(ValueError, match="the camera has 16x16 pixels"):
            renderer.render(swiftgs.Camera.builtin(16, 16), out=out)


def test_a_frame_keeps_the_memory_that_it_draws_into(renderer, camera, expected):
    out = swiftgs.Frame(np.zeros((HEIGHT, WIDTH, 3), np.float32))
    gc.collect()
    assert np.array_equal(renderer.render(camera, out=out).colour, expected.colour)
    lent = Lent(np.zeros((HEIGHT, WIDTH, 3), np.float32))
    out, kept = swiftgs.Frame(lent), lent.array
    del lent
    gc.collect()
    renderer.render(camera, out=out)
    assert np.array_equal(kept, expected.colour)


def test_renderers_keep_their_scene_and_share_it(camera, expected):
    first, second = swiftgs.Renderer("cpu", scene=swiftgs.Scene.builtin(2000)), swiftgs.Renderer("cpu")
    second.share_scene(first)
    with first:
        pass
    gc.collect()
    assert np.array_equal(second.render(camera).colour, expected.colour)
    for use in (lambda: first.render(camera), lambda: first.statistics, first.__enter__, lambda: first.device_name):
        with pytest.raises(ValueError, match="the renderer is closed"):
            use()
    assert repr(first).endswith("closed>")


def test_threads_draw_at_once_and_take_turns_at_one_renderer(renderer, scene, camera, expected):
    wrong = []
    shared = swiftgs.Frame.empty(WIDTH, HEIGHT)

    def work(own):
        for _ in range(20):
            if not np.array_equal(own.render(camera).colour, expected.colour):
                wrong.append("own frame")
            renderer.render(camera, out=shared)

    own = swiftgs.Renderer("cpu", scene=scene, threads=1)
    side_by_side(*[lambda: work(own), lambda: work(renderer)] * 2)
    assert not wrong and np.array_equal(shared.colour, expected.colour)


def test_other_threads_run_while_a_frame_is_drawn():
    renderer = swiftgs.Renderer("serial", scene=swiftgs.Scene.builtin(200_000))
    camera = swiftgs.Camera.builtin(640, 360)
    drawing = threading.Thread(target=renderer.render, args=(camera,))
    drawing.start()
    turns = 0
    while drawing.is_alive():
        drawing.join(0.001)
        turns += 1
    assert turns > 5


def test_a_renderer_may_be_closed_while_another_thread_draws(camera):
    scene, large = swiftgs.Scene.builtin(100_000), swiftgs.Camera.builtin(480, 270)
    expected = swiftgs.Renderer("serial", scene=scene).render(large).colour
    renderer, out = swiftgs.Renderer("serial", scene=scene), swiftgs.Frame(np.zeros((270, 480, 3), np.float32))
    drawing = threading.Thread(target=renderer.render, args=(large,), kwargs={"out": out})
    drawing.start()
    while drawing.is_alive() and not out.colour.any():
        time.sleep(0.001)
    renderer.close()
    with pytest.raises(ValueError, match="the renderer is closed"):
        renderer.render(camera)
    drawing.join()
    assert np.array_equal(out.colour, expected)


def test_images_are_saved(renderer, camera, tmp_path):
    frame = renderer.render([camera, camera], alpha=True, depth=True)
    frame.save(tmp_path / "a.pfm", 1)
    renderer.render(camera, format="rgba8").save(str(tmp_path / "a.png"))
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    read = swiftgs.load_image(tmp_path / "a.pfm")
    assert read.dtype == np.float32 and np.array_equal(read, frame.colour[1])
    straight = swiftgs.load_image(tmp_path / "a.png")
    assert straight.shape == (HEIGHT, WIDTH, 4)
    covered = frame.alpha[0] > 0.5
    wanted = (frame.colour[0] / np.maximum(frame.alpha[0], 1e-9)[..., None]).clip(0, 1)
    assert covered.any() and np.abs(straight[..., :3] - wanted)[covered].max() < 2.1 / 255
    assert np.abs(straight[..., 3] - frame.alpha[0]).max() < 0.6 / 255
    frame = renderer.render([camera, camera], **{**ALL_PLANES, "features": 0})
    try:
        frame.save(tmp_path / "a.exr", 1)
    except swiftgs.Unavailable:
        pass
    else:
        header = (tmp_path / "a.exr").read_bytes()[:2000]
        for channel in (b"normal.Y", b"depth.first", b"id.gaussian", b"id.median", b"A", b"Z"):
            assert b"\0" + channel + b"\0" in header, channel
        assert np.array_equal(swiftgs.load_image(tmp_path / "a.exr")[..., :3], frame.colour[1])
    with pytest.raises(swiftgs.FileError, match="none.png"):
        swiftgs.load_image(tmp_path / "none.png")
    with pytest.raises(swiftgs.InvalidArgument, match="a.gif"):
        frame.save(tmp_path / "a.gif", 0)
    with pytest.raises(ValueError, match="expected a frame on the host with colour"):
        renderer.render(camera, colour=False, depth=True).save(tmp_path / "b.png")


def test_a_batch_is_saved_an_image_at_a_time(renderer, camera, tmp_path):
    frame = renderer.render([camera, seen_from(0, -1, -5)])
    with pytest.raises(swiftgs.InvalidArgument, match="save: index is None in a frame of 2 images, expected one from 0 "
                       "to 1, such as '.*/a_0.png' with index 0 up to '.*/a_1.png' with index 1"):
        frame.save(tmp_path / "a.png")
    assert not list(tmp_path.iterdir())
    for index in (0, 1, -1):
        frame.save(tmp_path / "a.pfm", index)
        assert np.array_equal(swiftgs.load_image(tmp_path / "a.pfm"), frame.colour[index])
    renderer.render([camera]).save(tmp_path / "one.png")  # a batch of one has no other
    assert (tmp_path / "one.png").exists()


@pytest.mark.parametrize("form", ["rgb", "rgba", "rgba-half", "rgba8"])
def test_a_frame_is_shown_by_notebooks_as_what_it_saves(renderer, camera, tmp_path, form):
    frame = renderer.render(camera, format=form, alpha=form == "rgb")
    frame.save(tmp_path / "a.png")
    assert frame._repr_png_() == (tmp_path / "a.png").read_bytes()
    assert swiftgs.load_image(tmp_path / "a.png").shape == (HEIGHT, WIDTH, 4)
    assert renderer.render([camera, camera])._repr_png_() is None
    assert renderer.render(camera, colour=False, depth=True)._repr_png_() is None


def test_rows_that_go_up_are_saved_from_the_top(renderer, camera, tmp_path):
    memory = np.zeros((HEIGHT, WIDTH + 3, 4), np.uint8)
    out = renderer.render(camera, out=swiftgs.Frame(memory[::-1, :WIDTH]))
    assert out._repr_png_() == renderer.render(camera, format="rgba8")._repr_png_()


@pytest.mark.parametrize("form", ["rgb", "rgba", "rgba8"])
def test_what_is_before_a_background_is_saved_as_a_whole(renderer, camera, tmp_path, form):
    frame = renderer.render([camera, camera], format=form, alpha=True, background=[(0, 0, 0), (1, 0.5, 0)])
    frame.save(tmp_path / "a.png", 0)
    assert swiftgs.load_image(tmp_path / "a.png").shape == (HEIGHT, WIDTH, 4)
    frame.save(tmp_path / "a.png", 1)
    found = swiftgs.load_image(tmp_path / "a.png")
    wanted = renderer.render(camera, background=(1, 0.5, 0)).colour.clip(0, 1)
    assert found.shape == (HEIGHT, WIDTH, 3) and np.abs(found - wanted).max() < 1.01 / 255


def test_what_lies_over_a_picture_is_saved_as_a_whole(renderer, camera, tmp_path):
    alpha = np.empty((HEIGHT, WIDTH), np.float32)
    out = renderer.render(camera, out=swiftgs.Frame(np.ones((HEIGHT, WIDTH, 3), np.float32), alpha, over=True))
    out.save(tmp_path / "a.png")
    found = swiftgs.load_image(tmp_path / "a.png")
    assert found.shape == (HEIGHT, WIDTH, 3) and np.abs(found - out.colour.clip(0, 1)).max() < 0.51 / 255


def test_without_a_device_what_needs_one_is_refused(scene):
    if has_device():
        pytest.skip("there is a device; tests/python/test_device.py has the other half")
    with pytest.raises((swiftgs.Unavailable, swiftgs.InvalidArgument), match="renderer 'cuda"):
        swiftgs.Renderer("cuda", scene=scene)
    with pytest.raises(swiftgs.Unavailable, match="swiftgs_device_"):
        swiftgs.DeviceArray((2, 2))
