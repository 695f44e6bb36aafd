# SPDX-License-Identifier: Apache-2.0
"""Arrays of JAX, which nothing writes to, on the host and on a device if there is one."""
import numpy as np
import pytest

import swiftgs
from conftest import HEIGHT, OF_ALL, WIDTH, decibels, has_device

jax = pytest.importorskip("jax", reason="no JAX here")


def devices():
    found = jax.devices("cpu")[:1]
    try:
        return found + (jax.devices("cuda")[:1] if has_device() else [])
    except RuntimeError:
        return found


on_each_device = pytest.mark.parametrize("device", devices(), ids=lambda device: device.platform)


def arrays(arguments, device):
    return dict(arguments, **{name: jax.device_put(arguments[name], device) for name in OF_ALL})


@on_each_device
def test_arrays_come_back_as_arrays_of_jax(device, gsplat_arguments):
    plain = swiftgs.rasterization(**gsplat_arguments)
    given = arrays(gsplat_arguments, device)
    for mode, channels in (("RGB", 3), ("D", 1), ("RGB+ED", 4)):
        images, alphas, _ = swiftgs.rasterization(**given, render_mode=mode)
        assert isinstance(images, jax.Array) and images.devices() == {device} and alphas.devices() == {device}
        assert images.shape == (1, HEIGHT, WIDTH, channels)
        if mode != "D":
            assert decibels(images[..., :3], plain[0]) > 80 and decibels(alphas, plain[1]) > 80


@on_each_device
def test_images_are_not_written_again_by_later_frames(device, gsplat_arguments):
    given = arrays(gsplat_arguments, device)
    first = swiftgs.rasterization(**given)[0]
    copy = np.array(first)
    backgrounds = np.ones((1, 3), np.float32)
    images = [swiftgs.rasterization(**given, backgrounds=backgrounds)[0] for _ in range(10)]
    assert np.array_equal(first, copy) and not np.array_equal(images[-1], copy)


@on_each_device
def test_what_was_computed_just_before_is_drawn(device, gsplat_arguments):
    given = arrays(gsplat_arguments, device)
    wanted = np.array(swiftgs.rasterization(**given)[0])
    late = jax.jit(lambda means, noise: means + 0 * jax.numpy.linalg.norm(noise @ noise @ noise) * 1e-30)
    noise = jax.device_put(np.ones((2048, 2048), np.float32), device)
    for _ in range(5):
        images = swiftgs.rasterization(**dict(given, means=late(given["means"], noise)))[0]
        assert np.array_equal(np.array(images * 1), wanted)


@on_each_device
def test_arrays_of_jax_are_not_drawn_into(device):
    with pytest.raises(TypeError, match="colour is an array of JAX, which cannot be written to"):
        swiftgs.Frame(jax.device_put(np.zeros((HEIGHT, WIDTH, 3), np.float32), device))
