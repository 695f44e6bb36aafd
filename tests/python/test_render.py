# SPDX-License-Identifier: Apache-2.0
"""Frames on the host."""
import gc
import math
import os
import re
import threading
import time
import weakref

import numpy as np
import pytest

import swiftgs
from conftest import HEIGHT, WIDTH, Lent, arrays_of, has_device, seen_from, side_by_side
from swiftgs._c import PLANES


def test_the_table_has_every_renderer_and_names_the_usual_one():
    table = swiftgs.list_renderers()
    assert len(table) > 50 and all(entry.name.count("/") == 3 for entry in table)
    usable = {entry.name.split("/")[0] for entry in table if entry.usable}
    best = swiftgs.Renderer().name
    assert best.split("/")[0] == ("cuda" if "cuda" in usable else "cpu")
    assert swiftgs.find_renderer().name == best and swiftgs.find_renderer(best).name == best
    assert swiftgs.find_renderer("serial") == (swiftgs.Renderer("serial").name, True, False)
    assert all(entry.on_device == entry.name.startswith("cuda/") for entry in table)


def test_a_renderer_tells_what_it_is(renderer):
    assert re.fullmatch(r"<swiftgs.Renderer cpu/early/\S+ on .*, 2,000 Gaussians>", repr(renderer))
    assert "thread" in renderer.device_name and not renderer.on_device
    assert "2 threads" in swiftgs.Renderer("cpu", threads=2).device_name or os.cpu_count() < 2


def test_scenes_are_uploaded_with_the_harmonics_that_were_asked_for(scene, camera):
    images = [swiftgs.Renderer("cpu", scene=scene, harmonics=kept).render(camera).colour
              for kept in ("smallest", "float", "half")]
    assert np.array_equal(images[0], images[1]) and not np.array_equal(images[1], images[2])
    assert np.abs(images[1] - images[2]).max() < 1e-2


def test_formats_and_conversions_have_names(renderer, camera, expected):
    assert expected.colour.shape == (HEIGHT, WIDTH, 3) and expected.alpha.shape == (HEIGHT, WIDTH)
    rgba = renderer.render(camera, format="rgba").colour
    assert np.array_equal(rgba[..., :3], expected.colour) and np.array_equal(rgba[..., 3], expected.alpha)
    half, bytes_ = (renderer.render(camera, format=form).colour for form in ("rgba-half", "rgba8"))
    assert half.dtype == np.float16 and np.array_equal(half, rgba.astype(np.float16)) and bytes_.dtype == np.uint8
    linear, encoded = (renderer.render(camera, conversion=conversion).colour.mean()
                       for conversion in ("srgb-to-linear", "linear-to-srgb"))
    assert linear < expected.colour.mean() < encoded
    only = renderer.render(camera, colour=False, depth=True)
    assert only.colour is None and only.alpha is None and np.array_equal(only.depth, expected.depth)


@pytest.fixture(scope="module")
def featured(scene):
    """A renderer whose Gaussians have two features: 1, and a whole number of its own."""
    features = np.stack([np.ones(len(scene)), np.arange(len(scene)) % 7 - 3], axis=1).astype(np.float32)
    return swiftgs.Renderer("serial", scene=swiftgs.Scene.from_arrays(**arrays_of(scene), any_rotations=False,
                                                                      features=features))


ALL_PLANES = {**dict.fromkeys(PLANES, True), "features": 2}


def test_planes_have_shapes_and_types_of_their_own(featured, camera):
    frame = featured.render(camera, **ALL_PLANES)
    for name in PLANES:
        channels = {"colour": (3,), "normal": (3,), "features": (2,)}.get(name, ())
        kind = np.uint32 if name.endswith("id") else np.float32
        assert getattr(frame, name).shape == (HEIGHT, WIDTH, *channels) and getattr(frame, name).dtype == kind, name
    assert np.all(frame.squared_depth >= 0.9999 * frame.depth ** 2)
    assert np.allclose(frame.features[..., 0], frame.alpha, atol=1e-5) and frame.features[..., 1].std() > 0.1
    picked = featured.pick_rectangle(30, 20, 9, 7)
    assert np.array_equal(picked["gaussian"], frame.id[20:27, 30:39])
    assert np.array_equal(picked["median"], frame.median_id[20:27, 30:39])


def test_planes_go_to_arrays_of_any_layout(featured, camera):
    wanted = featured.render(camera, **ALL_PLANES)
    normal = np.zeros((2, HEIGHT, 2 * WIDTH, 3), np.float32)[:, ::-1, WIDTH:]
    ids = np.zeros((2, HEIGHT, WIDTH, 1), np.uint32)
    features = np.zeros((2, HEIGHT, WIDTH, 1), np.float32)
    out = featured.render([camera, camera], out=swiftgs.Frame(normal=normal, id=ids, features=features))
    assert out.colour is None and out.normal is normal
    assert np.array_equal(normal[1], wanted.normal) and np.array_equal(ids[1, ..., 0], wanted.id)
    assert np.array_equal(features[0, ..., 0], wanted.features[..., 0])


def test_batches_have_an_image_for_each_camera(renderer, camera, expected):
    other, colours = seen_from(1, -2, -4), np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
    frame = renderer.render([camera, other, camera], background=colours, alpha=True)
    assert frame.colour.shape == (3, HEIGHT, WIDTH, 3) and frame.alpha.shape == (3, HEIGHT, WIDTH) and len(frame) == 3
    assert np.array_equal(renderer.render((camera,)).colour, expected.colour[None])
    for image, of, background in zip(frame.colour, (camera, other, camera), colours):
        assert np.array_equal(image, renderer.render(of, background=background).colour)


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


def test_over_and_occluder_and_first_pixel(renderer, camera, expected):
    colour = np.full((HEIGHT, WIDTH, 3), 0.25, np.float32)
    renderer.render(camera, out=swiftgs.Frame(colour, over=True))
    assert np.array_equal(colour, renderer.render(camera, background=(0.25, 0.25, 0.25)).colour)
    for depth, nearly_all in ((1e-3, True), (np.inf, False)):
        renderer.render(camera, occluder=np.full((HEIGHT, WIDTH), depth, np.float32), counts=True)
        assert renderer.statistics.nearly_all_hidden == nearly_all
    window_depth = np.full((HEIGHT, WIDTH), 1 - 1e-3 / 2, np.float32)  # of what stands at the depth 2
    stored = swiftgs.StoredDepth.perspective(1e-3, np.inf)
    depths = np.full((HEIGHT, WIDTH), 1 / (stored.r * np.float64(window_depth[0, 0]) + stored.s), np.float32)
    before = renderer.render(camera, occluder=window_depth, stored_depth=stored).colour
    assert np.array_equal(before, renderer.render(camera, occluder=depths).colour)
    assert not np.array_equal(before, expected.colour)
    band = swiftgs.Frame(np.zeros((16, 32, 3), np.float32), first_pixel=(16, 32))
    assert np.array_equal(renderer.render(camera, out=band).colour, expected.colour[32:48, 16:48])


def test_models_of_scenes_and_arrays_reach_the_frame(renderer, arrays, camera):
    model = swiftgs.RenderingModel(blur=0.1, antialiased=True, order="distance", colours="linear")
    said = swiftgs.Conventions(blur=0.1, antialiased=True, order="distance", colours="linear")
    wanted = renderer.render(camera, conventions=said).colour
    renderer.set_scene(swiftgs.Scene.from_arrays(**arrays, any_rotations=False, model=model))
    assert np.array_equal(renderer.render(camera).colour, wanted)
    renderer.set_gaussians(**arrays, any_rotations=False, model=model)
    assert np.array_equal(renderer.render(camera).colour, wanted)


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
    frame = renderer.render([seen_from(1, -2, -4), camera], alpha=True)
    x, y = WIDTH // 2, HEIGHT // 2
    middle = renderer.pick(x, y, view=1)
    assert 0 <= middle.gaussian < len(scene) and 0 < middle.weight <= frame.alpha[1, y, x]
    assert (middle.median is not None) == (frame.alpha[1, y, x] > 0.5) and middle != renderer.pick(x, y)
    around = renderer.pick_rectangle(x - 30, y - 12, 60, 24, view=1)
    assert around.shape == (24, 60) and around.dtype.names == swiftgs.Picked._fields
    assert around[12, 30].item()[:3] == middle[:3] and len(np.unique(around["gaussian"])) > 2


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


def test_images_are_saved_one_at_a_time(renderer, camera, tmp_path):
    frame = renderer.render([camera, seen_from(0, -1, -5)], **{**ALL_PLANES, "features": 0})
    for index in (0, 1, -1):
        frame.save(tmp_path / "a.pfm", index)
        read = swiftgs.load_image(tmp_path / "a.pfm")
        assert read.dtype == np.float32 and np.array_equal(read, frame.colour[index])
    try:
        frame.save(tmp_path / "a.exr", 1)
    except swiftgs.Unavailable:
        pass
    else:
        header = (tmp_path / "a.exr").read_bytes()[:2000]
        for channel in (b"normal.Y", b"depth.first", b"id.gaussian", b"id.median", b"A", b"Z"):
            assert b"\0" + channel + b"\0" in header, channel
    renderer.render([camera]).save(str(tmp_path / "one.png"))  # a batch of one has no other
    assert (tmp_path / "one.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("form", ["rgb", "rgba", "rgba-half", "rgba8"])
def test_a_frame_is_shown_by_notebooks_as_what_it_saves(renderer, camera, tmp_path, form):
    for background, channels in (((0, 0, 0), 4), ((1, 0.5, 0), 3)):
        frame = renderer.render(camera, format=form, alpha=form == "rgb", background=background)
        frame.save(tmp_path / "a.png")
        assert frame._repr_png_() == (tmp_path / "a.png").read_bytes()
        assert swiftgs.load_image(tmp_path / "a.png").shape == (HEIGHT, WIDTH, channels)
    assert renderer.render([camera, camera])._repr_png_() is None
    assert renderer.render(camera, colour=False, depth=True)._repr_png_() is None


def test_rows_that_go_up_are_saved_from_the_top_and_pictures_below_as_a_whole(renderer, camera, tmp_path):
    memory = np.zeros((HEIGHT, WIDTH + 3, 4), np.uint8)
    out = renderer.render(camera, out=swiftgs.Frame(memory[::-1, :WIDTH]))
    assert out._repr_png_() == renderer.render(camera, format="rgba8")._repr_png_()
    alpha = np.empty((HEIGHT, WIDTH), np.float32)
    renderer.render(camera, out=swiftgs.Frame(np.ones((HEIGHT, WIDTH, 3), np.float32), alpha, over=True)).save(
        tmp_path / "a.png")
    assert swiftgs.load_image(tmp_path / "a.png").shape == (HEIGHT, WIDTH, 3)


def test_vulkan_draws_into_arrays_of_the_host(scene, camera):
    if not any(entry.usable and entry.name.startswith("vulkan/") for entry in swiftgs.list_renderers()):
        pytest.skip("no renderer of vulkan runs here")
    renderer = swiftgs.Renderer("vulkan", scene=scene)
    frame = renderer.render(camera, format="rgba8")
    wanted = swiftgs.Renderer("serial", scene=scene).render(camera, format="rgba8")
    assert np.abs(np.int16(frame.colour) - np.int16(wanted.colour)).max() <= 1 and not renderer.on_device
    dark = np.full((3, 3), -1, np.float32)
    serial = swiftgs.Renderer("serial", scene=scene)
    for drawing in (renderer, serial):
        drawing.update_scene(first=2, sh0=dark[::2])
    found, wanted = (np.int16(drawing.render(camera, format="rgba8").colour) for drawing in (renderer, serial))
    assert np.abs(found - wanted).max() <= 1
    with pytest.raises(swiftgs.Unavailable, match="draws in memory of Vulkan, expected swiftgs_renderer_render"):
        renderer.reserve(camera, swiftgs.Frame(np.empty((HEIGHT, WIDTH, 3), np.float32)))


def test_without_a_device_what_needs_one_is_refused(scene):
    if has_device():
        pytest.skip("there is a device; tests/python/test_device.py has the other half")
    with pytest.raises((swiftgs.Unavailable, swiftgs.InvalidArgument), match="renderer 'cuda"):
        swiftgs.Renderer("cuda", scene=scene)
    with pytest.raises(swiftgs.Unavailable, match="swiftgs_device_"):
        swiftgs.DeviceArray((2, 2))
