# SPDX-License-Identifier: Apache-2.0
"""Arrays of CuPy, and of libraries that know __cuda_array_interface__ alone."""
import gc

import numpy as np
import pytest

import swiftgs
from conftest import HEIGHT, OF_ALL, WIDTH, decibels, need_device

cupy = pytest.importorskip("cupy", reason="no CuPy here")
need_device_or_skip = pytest.fixture(autouse=True)(need_device)


class Bare:
    """An array that shows nothing but __cuda_array_interface__."""

    def __init__(self, array):
        self.array = array

    @property
    def shape(self):
        return self.array.shape

    @property
    def __cuda_array_interface__(self):
        return self.array.__cuda_array_interface__


def arrays(arguments):
    return dict(arguments, **{name: cupy.asarray(arguments[name]) for name in OF_ALL})


def test_arrays_come_back_as_arrays_of_cupy(gsplat_arguments):
    plain = swiftgs.rasterization(**gsplat_arguments)
    for mode, channels in (("RGB", 3), ("D", 1), ("RGB+ED", 4)):
        images, alphas, _ = swiftgs.rasterization(**arrays(gsplat_arguments), render_mode=mode)
        assert isinstance(images, cupy.ndarray) and isinstance(alphas, cupy.ndarray)
        assert images.shape == (1, HEIGHT, WIDTH, channels)
        if mode != "D":
            assert decibels(images[..., :3].get(), plain[0]) > 80 and decibels(alphas.get(), plain[1]) > 80


def test_work_is_in_the_order_of_the_current_stream(gsplat_arguments):
    given = arrays(gsplat_arguments)
    wanted = swiftgs.rasterization(**given)[0].copy()
    cupy.cuda.Device().synchronize()
    noise = cupy.ones((4096, 4096), cupy.float32)
    with cupy.cuda.Stream(non_blocking=True) as stream:
        late = dict(given, means=cupy.zeros_like(given["means"]))
        for _ in range(20):
            noise = noise @ noise * 1e-4
        late["means"][...] = given["means"]
        image = swiftgs.rasterization(**late)[0]
        late["means"][...] = 1e6
        copy = image.copy()
        image[...] = 0
    stream.synchronize()
    assert bool((copy == wanted).all())


def test_frames_are_drawn_into_arrays_that_may_have_gaps_and_go_up(scene, camera):
    renderer = swiftgs.Renderer("cuda", scene=scene)
    wanted = renderer.render(camera).colour
    large = cupy.zeros((HEIGHT, WIDTH + 5, 3), cupy.float32)
    renderer.render(camera, out=swiftgs.Frame(large[::-1, 2:-3]))
    assert np.array_equal(large.get()[::-1, 2:-3], wanted) and not large[:, :2].any() and not large[:, -3:].any()


def test_arrays_without_dlpack(gsplat_arguments, scene, camera):
    given = arrays(gsplat_arguments)
    wanted = swiftgs.rasterization(**given)[0]
    for name in OF_ALL:
        given[name] = Bare(given[name])
    images, alphas, _ = swiftgs.rasterization(**given)
    assert isinstance(images, swiftgs.DeviceArray) and images.shape == (1, HEIGHT, WIDTH, 3)
    assert np.array_equal(images.numpy(), wanted.get()) and alphas.numpy().max() > 0.9
    assert bool((cupy.from_dlpack(images) == wanted).all()) and bool((cupy.asarray(images) == wanted).all())
    colour = cupy.zeros((HEIGHT, WIDTH, 3), cupy.float32)
    renderer = swiftgs.Renderer("cuda", scene=scene)
    renderer.render(camera, out=swiftgs.Frame(Bare(colour)))
    assert np.array_equal(colour.get(), renderer.render(camera).colour)


def test_memory_is_held_as_long_as_it_is_used(gsplat_arguments):
    wanted = swiftgs.rasterization(**arrays(gsplat_arguments))[0]
    given = {name: Bare(array) if name in OF_ALL else array for name, array in arrays(gsplat_arguments).items()}
    image = cupy.from_dlpack(swiftgs.rasterization(**given)[0])  # outlives the DeviceArray
    del given
    gc.collect()
    cupy.get_default_memory_pool().free_all_blocks()
    assert bool((image == wanted).all())
