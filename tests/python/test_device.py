# SPDX-License-Identifier: Apache-2.0
"""A device without a library of arrays."""
import ctypes
import gc

import numpy as np
import pytest

import swiftgs
from swiftgs import Placement, _arrays
from swiftgs._c import lib
from conftest import HEIGHT, WIDTH, decibels, need_device, side_by_side

pytestmark = pytest.mark.usefixtures("device")
device = pytest.fixture(need_device)


@pytest.fixture
def on_device(scene):
    return swiftgs.Renderer("cuda", scene=scene)


def test_frames_come_to_the_host(on_device, camera, expected):
    frame = on_device.render([camera, camera], alpha=True, depth=True, times=True)
    assert decibels(frame.colour[0], expected.colour) > 80 and np.array_equal(frame.colour[0], frame.colour[1])
    assert decibels(frame.alpha[0], expected.alpha) > 80 and on_device.times.total > 0
    assert "CUDA" not in repr(frame) and on_device.on_device and on_device.memory.device_total > 0


def test_frames_stay_on_the_device(on_device, camera):
    wanted = on_device.render(camera, depth=True)
    colour, depth = swiftgs.DeviceArray((HEIGHT, WIDTH, 3)), swiftgs.DeviceArray((HEIGHT, WIDTH))
    frame = on_device.render(camera, out=swiftgs.Frame(colour, depth=depth))
    assert frame.colour is colour and "CUDA device" in repr(frame) and "CUDA device" in repr(colour)
    assert np.array_equal(colour.numpy(), wanted.colour) and np.array_equal(np.asarray(depth), wanted.depth)
    with pytest.raises(ValueError, match="expected the host for 'cpu/"):
        swiftgs.Renderer("cpu").render(camera, out=frame)
    with pytest.raises(ValueError, match="expected a frame on the host"):
        frame.save("frame.png")
    with pytest.raises(swiftgs.CapacityError, match="device memory"):
        swiftgs.DeviceArray((1 << 20, 1 << 20))


def test_arrays_of_the_host_are_drawn_on_the_device(on_device, camera, arrays):
    wanted = on_device.render(camera).colour
    other = swiftgs.Renderer("cuda")
    other.set_gaussians(**arrays, any_rotations=False)
    assert np.array_equal(other.render(camera).colour, wanted)
    other.share_scene(on_device)
    del on_device
    gc.collect()
    assert np.array_equal(other.render(camera).colour, wanted)


def test_updates_take_arrays_of_the_device(on_device, scene, camera):
    with pytest.raises(swiftgs.InvalidArgument, match="update_scene: the arrays lie on the host, expected them on the "
                                                      "device, where 'cuda/"):
        on_device.update_scene(means=scene.means)
    before = on_device.render(camera).colour
    # A depth plane of one row is an array of the device: the opacities of 80 Gaussians.
    row = swiftgs.DeviceArray((1, WIDTH))
    on_device.render(swiftgs.Camera.builtin(WIDTH, 1), out=swiftgs.Frame(alpha=row))
    opacities = scene.opacities.copy()
    opacities[300:300 + WIDTH] = row.numpy()[0]

    class Flat:
        __cuda_array_interface__ = dict(row.__cuda_array_interface__, shape=(WIDTH,))

    on_device.update_scene(0, 300, opacities=Flat())
    wanted = swiftgs.Renderer("cuda", scene=swiftgs.Scene.from_arrays(
        scene.means, scene.scales, scene.rotations, opacities, scene.sh0, scene.sh_rest, any_rotations=False))
    found = on_device.render(camera).colour
    assert np.array_equal(found, wanted.render(camera).colour) and not np.array_equal(found, before)


def test_recorded_frames_are_drawn_on_the_device(scene, camera):
    renderer = swiftgs.Renderer("cuda", scene=scene)
    renderer.place([Placement(first=0, count=1000), Placement(first=1000)])
    wanted = renderer.render(camera).colour
    assert sum(renderer.visible_by_scene) == renderer.statistics.visible
    with pytest.raises(ValueError, match="the frame lies on the host, expected CUDA device"):
        renderer.reserve(camera, swiftgs.Frame.empty(WIDTH, HEIGHT))
    colour = swiftgs.DeviceArray((HEIGHT, WIDTH, 3))
    renderer.reserve(camera, swiftgs.Frame(colour), splats=4000, intersections=400_000)
    scenes = renderer.recorded_scenes
    found = _arrays.read(scenes.rotations, "rotations")
    assert found.shape == (2, 3, 3) and found.strides[1:] == (8, 24) and found.kind == "f8" and found.device is not None
    for scale, refused in [(1, []), (-1, [1]), (1, [])]:
        value, address = ctypes.c_double(scale), scenes.scales.__cuda_array_interface__["data"][0]
        lib.device_copy(address + found.strides[0], ctypes.byref(value), 8, 0)
        renderer.record()
        assert renderer.refused_scenes == refused and not renderer.report.overflowed
        assert np.array_equal(colour.numpy(), wanted) == (not refused)


def test_threads_have_renderers_of_their_own(scene, camera):
    wanted = swiftgs.Renderer("cuda", scene=scene).render(camera).colour
    images = []

    def work():
        own = swiftgs.Renderer("cuda", scene=scene)
        images.extend(own.render(camera).colour for _ in range(20))

    side_by_side(*[work] * 4)
    assert len(images) == 80 and all(np.array_equal(image, wanted) for image in images)


def test_ten_thousand_frames_and_many_renderers_keep_to_their_memory(scene, camera):
    renderer = swiftgs.Renderer("cuda", scene=scene)
    out = swiftgs.Frame(swiftgs.DeviceArray((HEIGHT, WIDTH, 3)))
    renderer.render(camera, out=out)
    for _ in range(5):
        swiftgs.Renderer("cuda", scene=scene).render(camera)
    gc.collect()
    before = renderer.memory.device_in_use
    for _ in range(10_000):
        renderer.render(camera, out=out)
    for _ in range(50):
        swiftgs.Renderer("cuda", scene=scene).render(camera)
        swiftgs.DeviceArray((1000, 1000))
    gc.collect()
    assert renderer.memory.device_in_use - before < 4 << 20
