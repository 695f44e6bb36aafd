# SPDX-License-Identifier: Apache-2.0
"""`rasterization` beside gsplat's own, where gsplat is installed and there is a device."""
import numpy as np
import pytest

import float64
import swiftgs
from conftest import decibels, need_device

torch = pytest.importorskip("torch", reason="no PyTorch here")
gsplat = pytest.importorskip("gsplat", reason="no gsplat here")
need_device_or_skip = pytest.fixture(autouse=True)(need_device)


@pytest.fixture(params=["builtin", "fox"])
def case(request):
    """Arguments of both functions, three views of one size, and what the first is in float64."""
    if request.param == "builtin":
        scene, camera = swiftgs.Scene.builtin(20_000), swiftgs.Camera.builtin(320, 180)
        cameras = [camera] + [swiftgs.Camera.look_at(eye, (0, 0, 0), width=320, height=180, vertical_fov=0.8)
                              for eye in ((1, -2, -4), (-3, -2, -3))]
    else:
        fox = request.getfixturevalue("fox")
        scene, cameras = swiftgs.load(fox), [camera.scaled(0.2) for camera in swiftgs.load_cameras(fox)[:3]]

    def tensor(array):
        return torch.tensor(np.asarray(array, np.float32), device="cuda")

    arguments = {"means": tensor(scene.means), "quats": tensor(scene.rotations), "scales": tensor(scene.scales),
                 "opacities": tensor(scene.opacities), "colors": tensor(scene.sh),
                 "viewmats": tensor([camera.viewmat for camera in cameras]),
                 "Ks": tensor([camera.K for camera in cameras]), "width": cameras[0].width,
                 "height": cameras[0].height, "sh_degree": scene.sh_degree}
    return arguments, float64.render_first(arguments)


@torch.no_grad()
@pytest.mark.parametrize("options", [
    {}, {"packed": False}, {"rasterize_mode": "antialiased"}, {"eps2d": 0.1}, {"near_plane": 1.0},
    {"render_mode": "RGB+ED"}, {"render_mode": "ED", "colors": None, "sh_degree": None}, {"sh_degree": 1},
    {"camera_model": "fisheye"}, {"camera_model": "ortho"}], ids=str)
def test_images_are_those_of_gsplat(case, options):
    arguments, _ = case
    if options.get("camera_model") == "ortho":  # focal lengths become pixels per unit of the scene
        arguments["Ks"][:, :2, :2] /= 4
    ours, our_alphas, _ = swiftgs.rasterization(**{**arguments, **options})
    theirs, their_alphas, _ = gsplat.rasterization(**{**arguments, **options})
    assert ours.shape == theirs.shape and our_alphas.shape == their_alphas.shape and ours.dtype == theirs.dtype
    assert ours.device == theirs.device
    colours = slice(0, 3) if "RGB" in options.get("render_mode", "RGB") else slice(0, 0)
    if colours.stop:
        assert decibels(ours[..., colours].cpu(), theirs[..., colours].cpu()) > 80
    assert decibels(our_alphas.cpu(), their_alphas.cpu()) > 80
    if "ED" in options.get("render_mode", ""):
        # In units of the scene: relative to the depth itself, where there is something.
        solid = their_alphas[..., 0] > 0.5
        relative = (ours[..., -1] - theirs[..., -1])[solid].abs() / theirs[..., -1][solid]
        assert relative.median() < 1e-5 and relative.mean() < 1e-3


@torch.no_grad()
def test_ours_is_the_closer_to_float64(case):
    arguments, wanted = case
    ours, theirs = (float64.distance(each.rasterization(**arguments)[0][0].cpu(), wanted) for each in (swiftgs, gsplat))
    print(f"from float64: swiftgs {ours}, gsplat {theirs}")
    assert ours["db_of_others"] > theirs["db_of_others"] and ours["db"] > 90 and ours["otherwise"] < 20


@torch.no_grad()
def test_colours_and_backgrounds(case):
    arguments, _ = case
    arguments = dict(arguments, colors=(arguments["colors"][:, 0] * 0.28209479 + 0.5).clamp(0, 1).contiguous(),
                     sh_degree=None, backgrounds=torch.rand(3, 3, device="cuda"))
    ours, theirs = swiftgs.rasterization(**arguments)[0], gsplat.rasterization(**arguments)[0]
    assert decibels(ours.cpu(), theirs.cpu()) > 80
