# SPDX-License-Identifier: Apache-2.0
"""Tensors of PyTorch on a device: streams, devices, memory."""
import pytest

import swiftgs
from conftest import HEIGHT, WIDTH, need_device

torch = pytest.importorskip("torch", reason="no PyTorch here")
from test_rasterization import batch_of  # noqa: E402  pylint: disable=wrong-import-position
from test_torch import tensors  # noqa: E402  pylint: disable=wrong-import-position


@pytest.fixture(autouse=True)
def device():
    need_device()
    if not torch.cuda.is_available():
        pytest.skip("no CUDA device for PyTorch")


@pytest.mark.parametrize("own_stream", [False, True])
def test_work_is_in_the_order_of_the_current_stream(own_stream, gsplat_arguments):
    given = tensors(gsplat_arguments, "cuda")
    wanted = swiftgs.rasterization(**given)[0].clone()
    stream = torch.cuda.Stream()
    renderer = swiftgs.Renderer("cuda", stream=stream) if own_stream else None
    noise = torch.randn(4096, 4096, device="cuda")
    torch.cuda.synchronize()
    for _ in range(5):
        with torch.cuda.stream(stream):
            late = dict(given, means=torch.zeros_like(given["means"]))
            for _ in range(20):
                noise = noise @ noise * 1e-3
            late["means"].copy_(given["means"])  # behind long work: to read it early would draw other Gaussians
            image = swiftgs.rasterization(**late, renderer=renderer)[0]
            late["means"].fill_(1e6)  # behind the frame: to read it late would draw none
            copy = image.clone()
            image.zero_()
        stream.synchronize()
        assert torch.equal(copy, wanted)


def test_a_batch_has_the_bits_of_each_scene_alone(gsplat_arguments):
    together, alone = batch_of(gsplat_arguments, 3, 2)
    given = tensors(together, "cuda")
    colours, alphas, _ = swiftgs.rasterization(**given, render_mode="RGB+ED")
    for world, arguments in enumerate(alone):
        wanted, wanted_alphas, _ = swiftgs.rasterization(**tensors(arguments, "cuda"), render_mode="RGB+ED")
        assert torch.equal(colours[world], wanted) and torch.equal(alphas[world], wanted_alphas)
    # Arrays with gaps, and harmonics beside band 0, are read where they lie too.
    wide = torch.cat([given["means"], torch.full_like(given["means"], torch.nan)], dim=-1)
    strided = dict(given, means=wide[..., :3])
    assert torch.equal(swiftgs.rasterization(**strided)[0], colours[..., :3])


def test_a_renderer_of_the_callers_keeps_its_arrays_and_draws_them_as_they_are(gsplat_arguments, camera):
    given = tensors(gsplat_arguments, "cuda")
    renderer = swiftgs.Renderer("cuda")
    swiftgs.rasterization(**given, renderer=renderer)
    wanted = renderer.render(camera).colour
    copied = swiftgs.Renderer("cuda")
    copied.set_gaussians(given["means"], given["scales"], given["quats"], given["opacities"],
                         given["colors"][:, 0].contiguous(), given["colors"][:, 1:].contiguous())
    assert (wanted == copied.render(camera).colour).all()
    means = given["means"]
    del given
    junk = [torch.full((1 << 20,), torch.nan, device="cuda") for _ in range(20)]  # would take memory that is free
    assert (renderer.render(camera).colour == wanted).all()
    means += 0.25
    assert not (renderer.render(camera).colour == wanted).all()
    del junk


def test_nothing_large_visits_the_host(scene, camera, gsplat_arguments):
    given = dict(tensors(gsplat_arguments, "cuda"), viewmats=camera.viewmat[None], Ks=camera.K[None])
    swiftgs.rasterization(**given)
    with torch.profiler.profile(activities=[torch.profiler.ProfilerActivity.CUDA]) as profile:
        swiftgs.rasterization(**given)
        torch.cuda.synchronize()
    names = [event.name for event in profile.events()]
    if not names:
        pytest.skip("the profiler of PyTorch sees no work of the device here")
    assert not [name for name in names if "DtoH" in name or "HtoD" in name], names


def test_ten_thousand_frames_keep_to_their_memory(gsplat_arguments):
    given = tensors(gsplat_arguments, "cuda")
    given.update(viewmats=gsplat_arguments["viewmats"], Ks=gsplat_arguments["Ks"])
    for _ in range(100):
        swiftgs.rasterization(**given)
    torch.cuda.synchronize()
    before = torch.cuda.mem_get_info()[0]
    for _ in range(10_000):
        swiftgs.rasterization(**given)
    torch.cuda.synchronize()
    assert before - torch.cuda.mem_get_info()[0] < 4 << 20


def test_a_graph_draws_the_poses_that_torch_writes(scene, camera):
    stream = torch.cuda.Stream()
    renderer, other = swiftgs.Renderer("cuda", scene=scene, stream=stream), swiftgs.Renderer("cuda", scene=scene)
    renderer.place([swiftgs.Placement(count=1000), swiftgs.Placement(first=1000)])
    colour = torch.zeros(HEIGHT, WIDTH, 3, device="cuda")
    frame = swiftgs.Frame(colour)
    torch.cuda.synchronize()
    renderer.reserve(camera, frame, splats=4000, intersections=400_000)
    translations, opacities = (torch.as_tensor(array, device="cuda") for array in renderer.recorded_scenes[2:4])
    assert translations.shape == (2, 3) and translations.dtype == torch.float64 and opacities.tolist() == [1, 1]
    graph = torch.cuda.CUDAGraph()
    step = torch.tensor([0.125, 0, 0], dtype=torch.float64, device="cuda")
    torch.cuda.synchronize()
    with torch.cuda.graph(graph, stream=stream):
        translations[1] += step
        renderer.record()
    images = []
    for number in range(1, 4):
        with torch.cuda.stream(stream):
            graph.replay()
        stream.synchronize()
        assert not renderer.report.overflowed and renderer.refused_scenes == []
        where = torch.eye(4, dtype=torch.float64)
        where[0, 3] = 0.125 * number
        other.place([swiftgs.Placement(count=1000), swiftgs.Placement(0, where, first=1000)])
        images.append(colour.cpu().numpy())
        assert (images[-1] == other.render(camera).colour).all()
    assert (images[0] != images[1]).any()


def test_updates_are_in_the_order_of_the_current_stream(scene, camera):
    renderer, other = swiftgs.Renderer("cuda", scene=scene), swiftgs.Renderer("cuda")
    means = torch.as_tensor(scene.means[100:400].copy(), device="cuda") + 0.25
    moved = scene.means.copy()
    moved[100:400] = means.cpu().numpy()
    other.set_gaussians(moved, scene.scales, scene.rotations, scene.opacities, scene.sh0, scene.sh_rest,
                        any_rotations=False)
    noise, late = torch.randn(4096, 4096, device="cuda"), torch.zeros_like(means)
    for _ in range(20):
        noise = noise @ noise * 1e-3
    late.copy_(means)  # behind long work
    renderer.update_scene(0, 100, means=late)
    late.zero_()
    assert (renderer.render(camera).colour == other.render(camera).colour).all()
