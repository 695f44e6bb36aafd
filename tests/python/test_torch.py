# SPDX-License-Identifier: Apache-2.0
"""Tensors of PyTorch, on the host and on a device if there is one. What needs a device is in test_torch_device.py."""
import gc

import numpy as np
import pytest

import swiftgs
from conftest import HEIGHT, OF_ALL, WIDTH, arrays_of, decibels, has_device, seen_from

torch = pytest.importorskip("torch", reason="no PyTorch here")

DEVICES = ["cpu"] + ["cuda"] * (has_device() and torch.cuda.is_available())
on_each_device = pytest.mark.parametrize("device", DEVICES)


def tensors(arguments, device):
    return dict(arguments, **{name: torch.tensor(arguments[name], device=device) for name in OF_ALL})


@pytest.fixture
def plain(gsplat_arguments):
    """Images of the same arguments in arrays of NumPy."""
    return swiftgs.rasterization(**gsplat_arguments)


@on_each_device
def test_tensors_come_back_on_their_device(device, gsplat_arguments, plain):
    given = tensors(gsplat_arguments, device)
    colours, alphas, meta = swiftgs.rasterization(**given, render_mode="RGB+ED")
    assert isinstance(colours, torch.Tensor) and colours.device == given["means"].device
    assert colours.shape == (1, HEIGHT, WIDTH, 4) and alphas.shape == (1, HEIGHT, WIDTH, 1)
    assert colours.dtype == alphas.dtype == torch.float32 and not colours.requires_grad
    assert meta["renderer"].startswith("cuda/" if device == "cuda" else "cpu/")
    assert decibels(colours[..., :3].cpu(), plain[0]) > 80 and decibels(alphas.cpu(), plain[1]) > 80
    if device == "cpu":
        assert np.array_equal(colours[..., :3].numpy(), plain[0])


@on_each_device
def test_matrices_may_stay_on_the_host_and_batches_have_the_bits_of_single_frames(device, gsplat_arguments, camera):
    other = seen_from(1, -2, -4)
    given = tensors(gsplat_arguments, device)
    matrices = [{"viewmats": c.viewmat[None], "Ks": c.K[None]} for c in (camera, other)]
    single = [swiftgs.rasterization(**dict(given, **m))[0] for m in matrices]
    both = {name: np.concatenate([m[name] for m in matrices]) for name in matrices[0]}
    backgrounds = torch.zeros(2, 3, device=device)
    images = swiftgs.rasterization(**dict(given, **both), backgrounds=backgrounds)[0]
    assert torch.equal(images, torch.cat(single)) and not torch.equal(images[0], images[1])


@on_each_device
def test_orders_and_broadcasts_are_taken(device, gsplat_arguments):
    given = tensors(gsplat_arguments, device)
    wanted = swiftgs.rasterization(**given)[0]
    given["means"] = given["means"].t().contiguous().t()
    given["colors"] = given["colors"].permute(2, 1, 0).contiguous().permute(2, 1, 0)
    given["quats"] = torch.cat([given["quats"], given["quats"]], dim=1)[:, :4]
    assert not given["means"].is_contiguous() and torch.equal(swiftgs.rasterization(**given)[0], wanted)
    given["opacities"] = torch.full((1,), 0.5, device=device).expand(2000)
    image = swiftgs.rasterization(**given)[0]
    given["opacities"] = given["opacities"].contiguous()
    assert torch.equal(swiftgs.rasterization(**given)[0], image)


@on_each_device
def test_gradients_are_refused_where_they_would_be_lost(device, gsplat_arguments):
    given = tensors(gsplat_arguments, device)
    wanted = swiftgs.rasterization(**given)[0]
    given["scales"].requires_grad_()
    with pytest.raises(ValueError, match="scales requires gradients, expected none: .* torch.no_grad"):
        swiftgs.rasterization(**given)
    with torch.no_grad():
        assert torch.equal(swiftgs.rasterization(**given)[0], wanted)


@on_each_device
def test_frames_are_drawn_into_tensors(device, scene, camera):
    renderer = swiftgs.Renderer("cuda" if device == "cuda" else "cpu", scene=scene)
    wanted = renderer.render(camera, format="rgba", depth=True)
    large = torch.zeros(3, HEIGHT, 2 * WIDTH, 4, device=device)
    depth = torch.zeros(1, HEIGHT, WIDTH, device=device)
    frame = swiftgs.Frame(large[1:2, :, WIDTH:], depth=depth)
    assert renderer.render([camera], out=frame) is frame
    assert np.array_equal(large[1, :, WIDTH:].cpu(), wanted.colour) and np.array_equal(depth[0].cpu(), wanted.depth)
    assert not large[0].any() and not large[:, :, :WIDTH].any()
    for kind, name in ((torch.float16, "rgba-half"), (torch.uint8, "rgba8")):
        image = torch.zeros(HEIGHT, WIDTH, 4, dtype=kind, device=device)
        renderer.render(camera, out=swiftgs.Frame(image))
        assert np.array_equal(image.cpu(), renderer.render(camera, format=name).colour)


@on_each_device
def test_arrays_and_renderers_outlive_each_other(device, gsplat_arguments, plain):
    images = []
    for _ in range(20):
        given = tensors(gsplat_arguments, device)  # goes with the round, its memory to the next
        renderer = swiftgs.Renderer("cuda" if device == "cuda" else "cpu")
        images.append(swiftgs.rasterization(**given, renderer=renderer)[0])
        del given, renderer
    gc.collect()
    assert all(torch.equal(image, images[0]) for image in images) and decibels(images[0].cpu(), plain[0]) > 80


@on_each_device
def test_a_renderer_keeps_gaussians_that_were_given_up(device, scene, camera):
    renderer = swiftgs.Renderer("cuda" if device == "cuda" else "cpu", scene=scene)
    wanted = renderer.render(camera).colour
    arrays = {name: torch.tensor(array, device=device) for name, array in arrays_of(scene).items()}
    read = swiftgs.Scene.from_arrays(**arrays, any_rotations=False)
    renderer.set_gaussians(**arrays, any_rotations=False)
    for array in arrays.values():
        array.zero_()
    assert np.array_equal(renderer.render(camera).colour, wanted)
    assert np.array_equal(read.means, scene.means) and np.array_equal(read.sh_rest, scene.sh_rest)


@on_each_device
def test_a_type_that_numpy_does_not_know_is_named(device, gsplat_arguments):
    given = tensors(gsplat_arguments, device)
    with pytest.raises(TypeError, match="colors has numbers of type bf2"):
        swiftgs.rasterization(**dict(given, colors=given["colors"].bfloat16()))
