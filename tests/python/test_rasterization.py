# SPDX-License-Identifier: Apache-2.0
"""`rasterization` on the host, with gsplat's arguments."""
import inspect
import re

import numpy as np
import pytest

import float64
import swiftgs
from conftest import HEIGHT, OF_ALL, OF_GAUSSIANS, ROOT, WIDTH, Lent, decibels, seen_from

PAGE = (ROOT / "docs/python.md").read_text()


@pytest.fixture
def same_rotations(arrays):
    """A renderer whose quaternions were normalised once more, as those of `rasterization` are."""
    renderer = swiftgs.Renderer("cpu")
    renderer.set_gaussians(**arrays)
    return renderer


def test_one_camera(same_rotations, camera, gsplat_arguments):
    frame = same_rotations.render(camera, alpha=True)
    colours, alphas, meta = swiftgs.rasterization(**gsplat_arguments)
    assert colours.shape == (1, HEIGHT, WIDTH, 3) and alphas.shape == (1, HEIGHT, WIDTH, 1)
    assert colours.dtype == alphas.dtype == np.float32
    assert decibels(colours[0], frame.colour) > 90  # the camera's matrices are float32 here
    assert (meta["width"], meta["height"], meta["n_cameras"]) == (WIDTH, HEIGHT, 1)
    gsplat_arguments.update(viewmats=camera.viewmat[None], Ks=camera.K[None])  # in double
    colours, alphas, _ = swiftgs.rasterization(**gsplat_arguments)
    assert np.array_equal(colours[0], frame.colour) and np.array_equal(alphas[0, ..., 0], frame.alpha)


def test_images_are_those_of_a_plain_renderer_in_float64():
    scene, camera = swiftgs.Scene.builtin(5000), swiftgs.Camera.builtin(160, 90)
    wanted = float64.render(scene.means, scene.rotations, scene.scales, scene.opacities, scene.sh, camera.viewmat,
                            camera.K, 160, 90)
    colours, _, _ = swiftgs.rasterization(scene.means, scene.rotations, scene.scales, scene.opacities, scene.sh,
                                          camera.viewmat[None], camera.K[None], 160, 90, sh_degree=3)
    assert decibels(colours[0], wanted) > 110


def test_batches_of_cameras_with_backgrounds(gsplat_arguments, camera):
    other = seen_from(1, -2, -4)
    backgrounds = np.array([[1, 0, 0], [0, 0, 1]], np.float32)
    gsplat_arguments.update(viewmats=np.stack([camera.viewmat, other.viewmat]), Ks=np.stack([camera.K, other.K]))
    colours, alphas, meta = swiftgs.rasterization(**gsplat_arguments, backgrounds=backgrounds)
    assert colours.shape == (2, HEIGHT, WIDTH, 3) and meta["n_cameras"] == 2
    plain, _, _ = swiftgs.rasterization(**gsplat_arguments)
    assert np.allclose(colours, plain + (1 - alphas) * backgrounds[:, None, None], atol=1e-6)
    gsplat_arguments.update(viewmats=other.viewmat[None], Ks=other.K[None])
    assert np.array_equal(swiftgs.rasterization(**gsplat_arguments)[0][0], plain[1])


def test_depths(gsplat_arguments, expected):
    modes = {mode: swiftgs.rasterization(**gsplat_arguments, render_mode=mode)[0]
             for mode in ("RGB", "D", "ED", "RGB+D", "RGB+ED")}
    alphas = swiftgs.rasterization(**gsplat_arguments)[1]
    assert {mode: image.shape[-1] for mode, image in modes.items()} == {
        "RGB": 3, "D": 1, "ED": 1, "RGB+D": 4, "RGB+ED": 4}
    assert np.array_equal(modes["RGB+ED"][..., :3], modes["RGB"])
    assert np.array_equal(modes["RGB+ED"][..., 3:], modes["ED"])
    assert np.array_equal(modes["RGB+D"][..., 3:], modes["D"]) and np.array_equal(modes["D"], modes["ED"] * alphas)
    assert np.allclose(modes["ED"][0, ..., 0], expected.depth, rtol=1e-3, atol=1e-3)
    without = dict(gsplat_arguments, colors=None, sh_degree=None)
    assert np.array_equal(swiftgs.rasterization(**without, render_mode="ED")[0], modes["ED"])


def test_colours_without_harmonics(gsplat_arguments, scene):
    colours = np.clip(scene.sh0 * 0.28209479 + 0.5, 0, 1).astype(np.float32)
    image, _, _ = swiftgs.rasterization(**dict(gsplat_arguments, colors=colours, sh_degree=None))
    first, _, _ = swiftgs.rasterization(**dict(gsplat_arguments, colors=scene.sh, sh_degree=0))
    clipped = swiftgs.rasterization(**dict(gsplat_arguments, colors=((colours - 0.5) / np.float32(0.28209479))[:, None],
                                           sh_degree=0))[0]
    assert decibels(image, clipped) > 110 and decibels(image, first) > 20


def test_colours_of_any_number_of_channels(gsplat_arguments):
    colours = np.random.default_rng(2).random((2000, 5), np.float32) - np.float32([0, 0, 0, 0, 1])
    given = dict(gsplat_arguments, colors=colours, sh_degree=None, renderer=swiftgs.Renderer("serial"))
    images, alphas, _ = swiftgs.rasterization(**given)
    assert images.shape == (1, HEIGHT, WIDTH, 5) and images.min() < 0
    for channels in (slice(0, 3), slice(2, 5)):
        three = np.maximum(colours[:, channels], 0)
        plain = swiftgs.rasterization(**dict(given, colors=three))[0]
        signals = swiftgs.rasterization(**dict(given, colors=np.concatenate([three, three[:, :1]], axis=1)))[0]
        assert decibels(signals[..., :3], plain) > 110
    with_depth = swiftgs.rasterization(**given, render_mode="RGB+ED")[0]
    assert with_depth.shape[-1] == 6 and np.array_equal(with_depth[..., :5], images)
    assert np.array_equal(with_depth[..., 5:], swiftgs.rasterization(**given, render_mode="ED")[0])
    ones = swiftgs.rasterization(**dict(given, colors=np.ones((2000, 1), np.float32)))[0]
    assert np.allclose(ones, alphas, atol=1e-5)


def test_signals_beside_the_colours(gsplat_arguments):
    given = dict(gsplat_arguments, renderer=swiftgs.Renderer("serial"))
    plain = swiftgs.rasterization(**given)[0]
    signals = np.random.default_rng(3).random((2000, 4), np.float32)
    images, _, meta = swiftgs.rasterization(**given, extra_signals=signals)
    assert np.array_equal(images, plain) and meta["render_extra_signals"].shape == (1, HEIGHT, WIDTH, 4)
    alone = swiftgs.rasterization(**dict(given, colors=signals, sh_degree=None))[0]
    assert np.array_equal(meta["render_extra_signals"], alone)
    for wrap in (np.asarray, Lent):
        both = dict(given, colors=wrap(signals), sh_degree=None, extra_signals=wrap(signals[:, ::-1].copy()))
        images, _, meta = swiftgs.rasterization(**both)
        assert np.array_equal(images, alone) and np.array_equal(meta["render_extra_signals"], alone[..., ::-1])


def batch_of(arguments, worlds, cameras):
    """Another scene and other views for each world; the arguments for them all and for each."""
    rng, alone = np.random.default_rng(5), []
    for world in range(worlds):
        means = arguments["means"] + rng.normal(0, 0.3, 3).astype(np.float32)
        viewmats = np.repeat(arguments["viewmats"], cameras, axis=0)
        viewmats[:, 0, 3] += np.arange(cameras, dtype=np.float32) / 4 - world / 8
        alone.append(dict(arguments, means=means, viewmats=viewmats, Ks=np.repeat(arguments["Ks"], cameras, axis=0),
                          backgrounds=rng.uniform(0, 1, (cameras, 3)).astype(np.float32)))
    together = dict(arguments, **{name: np.stack([each[name] for each in alone]) for name in (*OF_ALL, "backgrounds")})
    return together, alone


@pytest.mark.parametrize("cameras", (1, 3))
def test_a_batch_has_the_bits_of_each_scene_alone(cameras, gsplat_arguments):
    together, alone = batch_of(gsplat_arguments, 4, cameras)
    for name in (*OF_ALL, "backgrounds"):
        together[name] = together[name].reshape(2, 2, *together[name].shape[1:])
    for mode in ("RGB", "RGB+ED", "D"):
        colours, alphas, meta = swiftgs.rasterization(**together, render_mode=mode)
        assert colours.shape[:5] == (2, 2, cameras, HEIGHT, WIDTH) and alphas.shape == (2, 2, cameras, HEIGHT, WIDTH, 1)
        assert (meta["n_batches"], meta["n_cameras"]) == (4, cameras)
        for world, arguments in enumerate(alone):
            wanted, wanted_alphas, _ = swiftgs.rasterization(**arguments, render_mode=mode)
            assert np.array_equal(colours[world // 2, world % 2], wanted)
            assert np.array_equal(alphas[world // 2, world % 2], wanted_alphas)
    assert not np.array_equal(colours[0, 0], colours[0, 1])


def test_a_batch_has_lenses_signals_and_colours_of_its_own(gsplat_arguments):
    together, alone = batch_of(gsplat_arguments, 2, 2)
    rng = np.random.default_rng(6)
    count = len(gsplat_arguments["means"])
    own = {"radial_coeffs": rng.uniform(-0.02, 0.02, (2, 2, 4)), "colors": rng.uniform(0, 1, (2, count, 3)),
           "extra_signals": rng.normal(0, 1, (2, count, 5))}
    own = {name: array.astype(np.float32) for name, array in own.items()}
    options = {"sh_degree": None, "camera_model": "fisheye"}
    colours, _, meta = swiftgs.rasterization(**dict(together, **own, **options))
    for world, arguments in enumerate(alone):
        mine = {name: array[world] for name, array in own.items()}
        wanted, _, of_one = swiftgs.rasterization(**dict(arguments, **mine, **options))
        assert np.array_equal(colours[world], wanted)
        assert np.array_equal(meta["render_extra_signals"][world], of_one["render_extra_signals"])


def test_a_batch_of_one_and_of_empty_scenes(gsplat_arguments):
    together, alone = batch_of(gsplat_arguments, 1, 1)
    assert np.array_equal(swiftgs.rasterization(**together)[0][0], swiftgs.rasterization(**alone[0])[0])
    together, _ = batch_of(gsplat_arguments, 2, 1)
    for name in OF_GAUSSIANS:
        together[name] = together[name][:, :0]
    colours, alphas, _ = swiftgs.rasterization(**together)
    assert (colours == together["backgrounds"][:, :, None, None]).all() and not alphas.any()


def test_quaternions_need_no_length_and_conventions_are_arguments(gsplat_arguments):
    plain = swiftgs.rasterization(**gsplat_arguments)[0]
    longer = dict(gsplat_arguments, quats=gsplat_arguments["quats"] * 5)
    assert decibels(swiftgs.rasterization(**longer)[0], plain) > 90
    for change in ({"near_plane": 5.0}, {"far_plane": 5.0}, {"eps2d": 1.0}, {"rasterize_mode": "antialiased"}):
        assert decibels(swiftgs.rasterization(**gsplat_arguments, **change)[0], plain) < 60, change


@pytest.mark.parametrize("change", [
    {"packed": False}, {"tile_size": 8}, {"channel_chunk": 2}, {"segmented": True}, {"absgrad": True},
    {"sparse_grad": True}, {"ut_params": object()}, {"ftheta_coeffs": object()}, {"renderer_config": object()},
    {"extra_signals_sh_degree": 3}, {"radial_coeffs": np.zeros((1, 6))}, {"tangential_coeffs": np.zeros((1, 2))},
    {"thin_prism_coeffs": np.zeros((1, 4))}, {"with_ut": True},
    {"rolling_shutter": "RollingShutterType.GLOBAL"}], ids=str)
def test_what_changes_no_image_is_taken(change, gsplat_arguments):
    plain = swiftgs.rasterization(**gsplat_arguments)[0]
    assert np.array_equal(swiftgs.rasterization(**gsplat_arguments, **change)[0], plain)


def test_other_orders_and_libraries_of_arrays(gsplat_arguments):
    plain = swiftgs.rasterization(**gsplat_arguments)[0]
    for change in (np.asfortranarray, lambda a: np.repeat(a, 2, axis=0)[::2], lambda a: Lent(a.copy())):
        given = dict(gsplat_arguments, **{name: change(gsplat_arguments[name]) for name in OF_GAUSSIANS})
        assert np.array_equal(swiftgs.rasterization(**given)[0], plain)
    given = dict(gsplat_arguments, viewmats=gsplat_arguments["viewmats"].tolist(),
                 Ks=Lent(gsplat_arguments["Ks"].copy()))
    assert np.array_equal(swiftgs.rasterization(**given)[0], plain)


def test_calls_with_the_same_arrays_draw_what_they_hold(gsplat_arguments):
    given = {name: array.copy() if name in OF_ALL else array for name, array in gsplat_arguments.items()}
    plain = swiftgs.rasterization(**given)[0]
    others = {name: np.roll(gsplat_arguments[name], 1, axis=0) for name in OF_GAUSSIANS}
    others.update(viewmats=gsplat_arguments["viewmats"] + np.eye(4, k=3, dtype=np.float32),
                  Ks=gsplat_arguments["Ks"] * np.float32([[0.9, 0.9, 1]]))
    for name, other in others.items():
        before = given[name].copy()
        given[name][:] = other
        changed, fresh = swiftgs.rasterization(**given)[0], dict(given, **{name: given[name].copy()})
        assert not np.array_equal(changed, plain), name
        assert np.array_equal(changed, swiftgs.rasterization(**fresh, renderer=swiftgs.Renderer("cpu"))[0]), name
        given[name][:] = before
        assert np.array_equal(swiftgs.rasterization(**given)[0], plain), name


def test_no_call_leaves_anything_to_the_next(gsplat_arguments):
    changes = [{"backgrounds": np.ones((1, 3), np.float32)}, {"radial_coeffs": np.eye(1, 6)},
               {"camera_model": "ortho"}, {"width": WIDTH // 2}, {"render_mode": "RGB+ED"}, {"eps2d": 1.0}]
    plain = swiftgs.rasterization(**gsplat_arguments)[0]
    for change in changes:
        for _ in range(2):
            changed = swiftgs.rasterization(**dict(gsplat_arguments, **change))[0]
        assert changed.shape != plain.shape or not np.array_equal(changed, plain), change
        assert np.array_equal(swiftgs.rasterization(**gsplat_arguments)[0], plain), change
        with pytest.raises(swiftgs.InvalidArgument):
            swiftgs.rasterization(**dict(gsplat_arguments, radial_coeffs=np.full((1, 6), np.inf)))
        assert np.array_equal(swiftgs.rasterization(**gsplat_arguments)[0], plain), change


def test_a_renderer_of_the_callers(gsplat_arguments):
    plain = swiftgs.rasterization(**gsplat_arguments)[0]
    renderer = swiftgs.Renderer("serial/standard/per-pixel/ellipse")
    images, _, meta = swiftgs.rasterization(**gsplat_arguments, renderer=renderer)
    assert meta["renderer"] == renderer.name and decibels(images, plain) > 80
    assert renderer.statistics.gaussians == 2000


REFUSED = {
    "radius_clip": 1.0, "distributed": True, "camera_model": "ftheta",
    "covars": np.zeros((2000, 3, 3), np.float32), "with_eval3d": True, "return_normals": True,
    "global_z_order": False, "rays": np.zeros(1), "thin_prism_coeffs": np.array([[0, 0, 0, 1e-3]]),
    "lidar_coeffs": object(), "external_distortion_coeffs": object(), "viewmats_rs": np.zeros((1, 4, 4)),
    "rolling_shutter": "RollingShutterType.ROLLING_TOP_TO_BOTTOM",
    "render_mode": "d"}


@pytest.mark.parametrize("change", [
    *({name: value} for name, value in REFUSED.items()), {"camera_model": "lidar"},
    {"radial_coeffs": np.full((1, 6), 0.1), "camera_model": "ortho"},
    {"tangential_coeffs": np.full((1, 2), 0.1), "camera_model": "fisheye"},
    {"thin_prism_coeffs": np.full((1, 4), 0.1), "camera_model": "fisheye"},
    {"thin_prism_coeffs": np.full((1, 4), np.nan)}], ids=str)
def test_what_is_not_offered_is_refused_by_name(change, gsplat_arguments):
    with pytest.raises(NotImplementedError, match=f"rasterization: {next(iter(change))} is .*, expected"):
        swiftgs.rasterization(**gsplat_arguments, **change)


COEFFICIENTS = {"radial_coeffs": [[0.2, 0.05, 0.004, 0.03, 0.002, 0.001]], "tangential_coeffs": [[0.004, -0.003]],
                "thin_prism_coeffs": [[0.002, 0, -0.001, 0]], "with_ut": True}


@pytest.mark.parametrize("options, lens, focal", [
    ({"camera_model": "ortho"}, {"model": "orthographic"}, 12),
    ({"camera_model": "fisheye", "radial_coeffs": [[0.05, -0.01, 0.002, -0.0003]]},
     {"model": "fisheye", "radial": (0.05, -0.01, 0.002, -0.0003)}, 30),
    (COEFFICIENTS, {"radial": (0.2, 0.05, 0.004), "rational": (0.03, 0.002, 0.001), "tangential": (0.004, -0.003),
                    "prism": (0.002, -0.001)}, 60)], ids=str)
def test_lenses(options, lens, focal, gsplat_arguments, same_rotations, camera):
    K = np.array([[focal, 0, WIDTH / 2 + 3], [0, focal + 1, HEIGHT / 2 - 2], [0, 0, 1]], np.float64)
    gsplat_arguments.update(viewmats=camera.viewmat[None], Ks=K[None])
    given = {name: np.array(value) if name.endswith("coeffs") else value for name, value in options.items()}
    colours, alphas, _ = swiftgs.rasterization(**gsplat_arguments, **given, render_mode="RGB+ED")
    through = swiftgs.Camera.from_matrices(camera.viewmat, K, WIDTH, HEIGHT, **lens)
    frame = same_rotations.render(through, alpha=True, depth=True, conventions=swiftgs.Conventions(depth="z"))
    assert decibels(colours[0, ..., :3], frame.colour) > 100 and np.allclose(alphas[0, ..., 0], frame.alpha, atol=1e-5)
    assert np.allclose(colours[0, ..., 3], frame.depth, rtol=1e-3, atol=1e-3)
    pinhole = swiftgs.rasterization(**gsplat_arguments)[0]
    assert alphas.max() > 0.5 and decibels(pinhole[0], frame.colour) < 30


@pytest.mark.parametrize("change, kind, text", [
    ({"camera_model": "fisheye", "radial_coeffs": np.zeros((1, 6))}, ValueError,
     "radial_coeffs has the shape (1, 6), expected (1, 4)"),
    ({"radial_coeffs": np.zeros((1, 4))}, ValueError, "radial_coeffs has the shape (1, 4), expected (1, 6)"),
    ({"tangential_coeffs": np.zeros(2)}, ValueError, "tangential_coeffs has the shape (2,), expected (1, 2)"),
    ({"means": np.zeros((2, 2000, 3), np.float32)}, ValueError,
     "quats has the shape (2000, 4), expected the batch (2,) of means first, and 2 dimensions after it"),
    ({"means": np.zeros((0, 2000, 3), np.float32)}, ValueError, "expected a batch of one scene or more"),
    ({"colors": np.zeros((1, 2000, 3), np.float32), "sh_degree": None}, NotImplementedError, "colours of each camera"),
    ({"colors": np.zeros((2000, 16), np.float32), "sh_degree": None, "backgrounds": np.zeros((1, 16))},
     NotImplementedError, "backgrounds is an array of the shape (1, 16), expected None for colors of 16 channels"),
    ({"extra_signals": np.zeros((2000, 2), np.float32), "extra_signals_sh_degree": 1}, NotImplementedError,
     "extra_signals_sh_degree is 1, expected None"),
    ({"extra_signals": np.zeros((1, 2000, 2), np.float32)}, ValueError,
     "extra_signals has the shape (1, 2000, 2), expected (2000, N)"),
    ({"sh_degree": 4}, NotImplementedError, "sh_degree is 4, expected 0 to 3"),
    ({"colors": np.zeros((2000, 8, 3), np.float32)}, ValueError, "colors has 8 coefficients, expected 16 or more"),
    ({"colors": np.zeros((2000, 3), np.float32)}, ValueError, "colors has the shape (2000, 3), expected (2000, N, 3)"),
    ({"quats": np.zeros((2000, 3), np.float32)}, ValueError, "quats has the shape (2000, 3), expected (2000, 4)"),
    ({"means": np.zeros((2000, 3))}, TypeError, "means has numbers of type f8, expected float32 (f4)"),
    ({"viewmats": np.eye(4)}, ValueError, "viewmats has the shape (4, 4), expected (C, 4, 4)"),
    ({"viewmats": 2 * np.eye(4)[None]}, ValueError, "0, 0, 0, 1 in the last row"),
    ({"Ks": np.eye(3)}, ValueError, "Ks has the shape (3, 3), expected (1, 3, 3)"),
    ({"Ks": np.array([[[9, 1, 0], [0, 9, 0], [0, 0, 1]]])}, NotImplementedError, "Ks has a skew"),
    ({"backgrounds": np.zeros(3)}, ValueError, "backgrounds has the shape (3,), expected (1, 3)"),
    ({"rasterize_mode": "fast"}, ValueError, "rasterize_mode is 'fast', expected 'classic' or 'antialiased'")])
def test_what_does_not_fit_is_named(change, kind, text, gsplat_arguments):
    with pytest.raises(kind, match=re.escape(text)):
        swiftgs.rasterization(**dict(gsplat_arguments, **change))


def test_the_page_has_every_argument_in_its_table():
    table = PAGE[PAGE.index("| argument "):]
    table = table[:table.index("\n\n")]
    named = set(re.findall(r"`(\w+)`", "".join(line.split("|")[1] for line in table.splitlines())))
    arguments = set(inspect.signature(swiftgs.rasterization).parameters)
    assert named == arguments
    for name in REFUSED:
        row = next(line for line in table.splitlines() if re.search(rf"`{name}`", line.split("|")[1]))
        assert "refused" in row, name
