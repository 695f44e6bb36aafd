# SPDX-License-Identifier: Apache-2.0
"""Tensors of PyTorch on a device: streams, devices, memory."""
import pytest

import swiftgs
from conftest import HEIGHT, WIDTH, need_device

torch = pytest.importorskip("torch", reason="no PyTorch here")
from test_torch import tensors  # noqa: E402  pylint: disable=wrong-import-position


@pytest.fixture(autouse=True)
def device():
    need_device()
    if not torch.cuda.is_available():
        pytest.skip("no CUDA device for PyTorch")


def test_devices_are_not_mixed(gsplat_arguments, scene, camera):
    given, on_host = tensors(gsplat_arguments, "cuda"), tensors(gsplat_arguments, "cpu")
    with pytest.raises(ValueError, match="scales lies on the host and means on CUDA device 0"):
        swiftgs.rasterization(**dict(given, scales=on_host["scales"]))
    with pytest.raises(ValueError, match="means lies on CUDA device 0, expected the memory of the renderer 'cpu/"):
        swiftgs.rasterization(**given, renderer=swiftgs.Renderer("cpu"))
    image = torch.zeros(HEIGHT, WIDTH, 3, device="cuda")
    with pytest.raises(ValueError, match="the frame lies on CUDA device 0, expected the host for 'cpu/"):
        swiftgs.Renderer("cpu", scene=scene).render(camera, out=swiftgs.Frame(image))
    with pytest.raises(ValueError, match="alpha lies on the host, expected all planes on one"):
        swiftgs.Frame(image, torch.zeros(HEIGHT, WIDTH))


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
