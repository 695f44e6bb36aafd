# SPDX-License-Identifier: Apache-2.0
"""Placed scenes: several scenes in one frame."""
import gc
import re

import numpy as np
import pytest

import swiftgs
from conftest import HEIGHT, WIDTH, arrays_of, decibels
from swiftgs import Clip, NOTHING, Placement, Tint


def part_of(scene, chosen):
    """Some of a scene's Gaussians."""
    return swiftgs.Scene.from_arrays(**arrays_of(scene, chosen), any_rotations=False)


def pose(scale=1.0, translation=(0, 0, 0), angle=0.0):
    """A turn about y, a scale and a translation."""
    matrix = np.eye(4)
    matrix[0, 0], matrix[0, 2] = np.cos(angle), np.sin(angle)
    matrix[2, 0], matrix[2, 2] = -np.sin(angle), np.cos(angle)
    matrix[:3, :3] *= scale
    matrix[:3, 3] = translation
    return matrix


@pytest.fixture
def parts(scene):
    """Three parts of the scene, of different sizes."""
    return [part_of(scene, slice(0, 1000)), part_of(scene, slice(1000, 1620)), part_of(scene, slice(1620, None))]


@pytest.fixture
def placing(parts):
    """A renderer with these parts."""
    renderer = swiftgs.Renderer("cpu")
    assert [renderer.add_scene(part) for part in parts] == [0, 1, 2]
    return renderer


def test_parts_of_a_scene_are_the_scene(placing, renderer, camera):
    wanted = renderer.render(camera, id=True, depth=True)
    for placements in (None, [Placement(0), Placement(1), Placement(2)],
                       [Placement(k, np.eye(4), 1.0, Clip(radius=np.inf)) for k in range(3)]):
        if placements:
            placing.place(placements)
        found = placing.render(camera, id=True, depth=True)
        for plane in ("colour", "id", "depth"):
            assert np.array_equal(getattr(found, plane), getattr(wanted, plane))
    assert placing.statistics.gaussians == 2000
    assert repr(placing).endswith(", 2,000 Gaussians in 3 placed scenes>")
    placing.set_scene(swiftgs.Scene.builtin(2000))
    assert np.array_equal(placing.render(camera).colour, wanted.colour)
    assert repr(placing).endswith(", 2,000 Gaussians>")


def test_numbers_of_a_frame_tell_placements_and_indices(placing, arrays, camera):
    frame = placing.render(camera, id=True)
    placement, index = placing.placed_scene_of(frame.id)
    assert placement.shape == index.shape == (HEIGHT, WIDTH) and set(np.unique(placement)) == {0, 1, 2}
    firsts = np.array([0, 1000, 1620])
    assert np.array_equal(firsts[placement] + index, frame.id)

    # Of another order, with a scene that is there twice and one that is not.
    placing.place([Placement(2), Placement(0), Placement(0, pose(translation=(0.5, 0, 0)))])
    placement, index = placing.placed_scene_of([0, 379, 380, 1379, 1380, 2379, NOTHING])
    assert placement.tolist() == [0, 0, 1, 1, 2, 2, -1] and index.tolist() == [0, 379, 0, 999, 0, 999, -1]
    other = swiftgs.Renderer("cpu")
    other.share_scene(placing)
    assert other.placed_scene_of(2379)[0] == 2
    other.set_gaussians(**arrays)
    assert other.placed_scene_of(1999)[1] == 1999 and placing.placed_scene_of(2379)[0] == 2

    for numbers, error, message in [(2380, ValueError, "numbers have 2380, expected less than 2380 or NOTHING"),
                                    ([3, -1], ValueError, "numbers have -1, expected"),
                                    ([0.5], TypeError, "numbers are of type float64, expected whole numbers")]:
        with pytest.raises(error, match=message):
            placing.placed_scene_of(numbers)
    with pytest.raises(ValueError, match="numbers have 0, expected less than 0"):
        swiftgs.Renderer("cpu").placed_scene_of(0)


def test_placements_show_ranges_of_a_scene(renderer, scene, camera, expected):
    renderer.place([Placement(first=256, count=1000), Placement(first=1500), Placement(count=3)])
    parts = [part_of(scene, chosen) for chosen in (slice(256, 1256), slice(1500, None), slice(0, 3))]
    wanted = swiftgs.Renderer("cpu")
    for part in parts:
        wanted.add_scene(part)
    found = renderer.render(camera, id=True)
    assert np.array_equal(found.colour, wanted.render(camera).colour)
    assert not np.array_equal(found.colour, expected.colour)
    assert repr(renderer).endswith(", 1,503 Gaussians in 3 placed scenes>")
    placement, index = renderer.placed_scene_of([0, 999, 1000, 1499, 1500, 1502, NOTHING])
    assert placement.tolist() == [0, 0, 1, 1, 2, 2, -1] and index.tolist() == [256, 1255, 1500, 1999, 0, 2, -1]
    other = swiftgs.Renderer("cpu")
    other.share_scene(renderer)
    assert np.array_equal(other.render(camera).colour, found.colour) and other.placed_scene_of(1000)[1] == 1500


def test_matrices_move_scenes_as_cameras_move_the_other_way(renderer, camera, expected):
    for matrix in (pose(translation=(0.3, -0.2, 0.5)), pose(1.5), pose(0.7, (0.2, 0, 0.1), 0.4)):
        moved = camera.viewmat @ matrix
        moved[:3] /= np.cbrt(np.linalg.det(matrix[:3, :3]))
        renderer.place([Placement()])
        wanted = renderer.render(swiftgs.Camera.from_matrices(moved, camera.K, WIDTH, HEIGHT)).colour
        for given in (matrix, matrix.astype(np.float32), matrix.tolist()):
            renderer.place([Placement(world_from_scene=given)])
            found = renderer.render(camera).colour
            assert decibels(found, wanted) > 60 and decibels(found, expected.colour) < 40


def test_scenes_far_away_are_placed_by_their_origins(arrays, camera, expected):
    origin = np.array([4e6, -3e6, 5e6])
    far = swiftgs.Scene.from_arrays(**arrays, any_rotations=False, origin=origin)
    renderer = swiftgs.Renderer("cpu", scene=far)
    renderer.place([Placement(world_from_scene=pose(translation=far.origin))])
    world = camera.relative_to(-origin)
    assert decibels(renderer.render(world).colour, expected.colour) > 80


def test_clips_and_opacities_choose_what_shows(renderer, scene, camera, expected):
    means, low, high = scene.means, np.array([-0.6, -1, -1.5]), np.array([0.4, 0.5, 0.3])
    for clip, chosen in [
            (Clip.box(low, high), ((means >= low) & (means <= high)).all(axis=1)),
            (Clip.sphere((0, 0.2, -0.5), 0.8), ((means - [0, 0.2, -0.5]) ** 2).sum(axis=1) <= 0.8 ** 2),
            (Clip([[1, 0.5, 0, 0.1], [0, 0, -1, 0]], (0, 0, 0), 3),
             (means @ [1, 0.5, 0] + 0.1 >= 0) & (means[:, 2] <= 0) & ((means ** 2).sum(axis=1) <= 9))]:
        assert 50 < chosen.sum() < 1950
        renderer.place([Placement(clip=clip)])
        found = renderer.render(camera).colour
        wanted = swiftgs.Renderer("cpu", scene=part_of(scene, chosen)).render(camera).colour
        assert np.array_equal(found, wanted) and not np.array_equal(found, expected.colour)
    renderer.place([Placement(opacity=0.25)])
    faint = renderer.render(camera, alpha=True).alpha
    assert 0.1 < faint.mean() < expected.alpha.mean() - 0.05
    renderer.place([Placement(opacity=0)])
    assert renderer.render(camera, alpha=True).alpha.max() == 0


def test_tints_are_mixed_into_colours_and_show_a_pick(renderer, camera, expected):
    renderer.render(camera)
    i = renderer.pick(WIDTH // 2, HEIGHT // 2).gaussian

    def highlighted(tint):
        renderer.place([Placement(count=i), Placement(first=i, count=1, tint=tint), Placement(first=i + 1)])
        return renderer.render(camera).colour

    assert np.array_equal(highlighted(Tint((9, 0, 9), 0)), expected.colour)
    shown = highlighted(Tint((9, 0, 9), 1))
    assert shown[HEIGHT // 2, WIDTH // 2, 0] > expected.colour[HEIGHT // 2, WIDTH // 2, 0] + 0.1

    def tinted(tint):
        renderer.place([Placement(tint=tint)])
        return renderer.render(camera, alpha=True)

    whole = tinted(Tint((0.25, 0, 2), 1))
    assert np.allclose(whole.colour, whole.alpha[..., None] * np.float32([0.25, 0, 2]), rtol=1e-5, atol=1e-6)
    part = tinted(Tint(np.array([0.25, 0, 2]), np.float32(0.25)))
    assert np.array_equal(part.alpha, expected.alpha)
    assert np.allclose(part.colour, 0.75 * expected.colour + 0.25 * whole.colour, rtol=1e-5, atol=1e-6)


def test_images_show_ranges_of_placed_scenes(placing, parts, camera):
    wanted = []
    for some in ([0], [1, 2], [0, 1, 2]):
        renderer = swiftgs.Renderer("cpu")
        for number in some:
            renderer.add_scene(parts[number])
        wanted.append(renderer.render(camera).colour)
    frame = placing.render([camera] * 3, shows=[range(0, 1), range(1, 3), None])
    assert frame.shows == [range(0, 1), range(1, 3), None]
    for found, image in zip(frame.colour, wanted):
        assert np.array_equal(found, image)
    frame.shows = range(1, 3)
    placing.render([camera] * 3, out=frame)
    assert all(np.array_equal(found, wanted[1]) for found in frame.colour)
    frame.shows = None
    assert frame.shows == [None] * 3
    for shows, message in [(range(1, 1), "shows has range.1, 1., expected None or a range of one placed scene or more"),
                           (range(0, 4, 2), "shows has range.0, 4, 2."), (range(-1, 1), "shows has range.-1, 1."),
                           ([range(1)] * 2, "shows has 2 ranges, expected one, or 3, one an image"),
                           ([1, 2, 3], "shows has 1, expected None or a range")]:
        with pytest.raises(ValueError, match=message):
            frame.shows = shows
    with pytest.raises(swiftgs.InvalidArgument, match="a view shows 3 placed scenes from number 1 on, expected some of "
                                                      "the frame's 3"):
        placing.render(camera, shows=range(1, 4))


def test_what_cannot_be_placed_is_refused_and_changes_nothing(placing, renderer, camera):
    wanted = renderer.render(camera).colour
    shear, mirror, row = pose(), np.diag([1.0, 1, -1, 1]), pose()
    shear[0, 1], row[3, 0] = 0.5, 1
    for wrong, error, message in [
            ([], swiftgs.InvalidArgument, "place: expected one placement or more"),
            ([pose()], TypeError, "placement 0 is of type ndarray, expected swiftgs.Placement"),
            ([Placement(3)], swiftgs.InvalidArgument, "place: the scene is number 3, expected less than 3"),
            ([Placement(-1)], ValueError, "scene is -1, expected 0 or more"),
            ([Placement(world_from_scene=np.eye(3))], ValueError, r"world_from_scene has the shape \(3, 3\), expected"),
            ([Placement(world_from_scene="here")], TypeError, "world_from_scene is 'here', expected numbers"),
            ([Placement(world_from_scene=pose(np.nan))], ValueError, "expected finite numbers"),
            ([Placement(world_from_scene=row)], ValueError, r"has the last row \[1.0, 0.0, 0.0, 1.0\], expected"),
            ([Placement(world_from_scene=shear)], ValueError, "stretches scenes by 0.78.* to 1.28.*, expected"),
            ([Placement(world_from_scene=pose(0))], ValueError, "stretches scenes by 0 to 0, expected a"),
            ([Placement(world_from_scene=mirror)], ValueError, "world_from_scene mirrors scenes, expected"),
            ([Placement(), Placement(first=2, count=999)], swiftgs.InvalidArgument,
             "place: placement 1 shows 999 Gaussians from number 2 on, expected some of the 1000 of scene 0"),
            ([Placement(first=-1)], ValueError, "first is -1, expected 0 or more"),
            ([Placement(count=0)], ValueError, "count is 0, expected 1 or more"),
            ([Placement(first=1 << 64)], ValueError, "first is 18446744073709551616, expected 0 to"),
            ([Placement(opacity=1.1)], ValueError, "opacity is 1.1, expected 0 to 1"),
            ([Placement(opacity=float("nan"))], ValueError, "opacity is nan, expected 0 to 1"),
            ([Placement(tint=(1, 0, 0))], TypeError, "tint is of type tuple, expected swiftgs.Tint"),
            ([Placement(tint=Tint((1, 2)))], ValueError, r"colour has the shape \(2,\), expected \(3,\)"),
            ([Placement(tint=Tint((1, 0, -1)))], ValueError, r"colour is \[1.0, 0.0, -1.0\], expected 0 or more"),
            ([Placement(tint=Tint((1, np.nan, 0)))], ValueError, "colour is .1.0, nan, 0.0., expected finite numbers"),
            ([Placement(tint=Tint((1, 1e39, 0)))], swiftgs.InvalidArgument, "expected a tint with a finite colour"),
            ([Placement(tint=Tint(amount=-0.1))], ValueError, "amount is -0.1, expected 0 to 1"),
            ([Placement(tint=Tint(amount=float("nan")))], ValueError, "amount is nan, expected 0 to 1"),
            ([Placement(clip=(1, 2))], TypeError, "clip is of type tuple, expected swiftgs.Clip"),
            ([Placement(clip=Clip(np.ones((7, 4))))], ValueError, "half_spaces are 7, expected 6 at most"),
            ([Placement(clip=Clip([[1, 2, 3]]))], ValueError, r"half_spaces has the shape \(1, 3\), expected \(1, 4\)"),
            ([Placement(clip=Clip.sphere((0, 0), 1))], ValueError, r"centre has the shape \(2,\), expected \(3,\)"),
            ([Placement(clip=Clip.sphere((0, 0, 0), 0))], ValueError, "radius is 0, expected more than 0")]:
        with pytest.raises(error, match=message):
            placing.place(wrong)
    with pytest.raises(TypeError, match="scene is of type str, expected swiftgs.Scene"):
        placing.add_scene("a.ply")
    assert np.array_equal(placing.render(camera).colour, wanted)


def test_renderers_keep_the_scenes_that_they_place(placing, parts, renderer, camera):
    for part in parts:
        part.close()
    parts.clear()
    gc.collect()
    assert np.array_equal(placing.render(camera).colour, renderer.render(camera).colour)


def test_updates_replace_arrays_of_a_range(placing, camera, arrays):
    other = swiftgs.Renderer("cpu")
    other.share_scene(placing)
    before = placing.render(camera).colour
    wanted = {name: array.copy() for name, array in arrays.items()}

    def check():
        whole = swiftgs.Renderer("cpu", scene=swiftgs.Scene.from_arrays(**wanted, any_rotations=False))
        colour = whole.render(camera).colour
        assert not np.array_equal(colour, before)
        for renderer in (placing, other):
            assert np.array_equal(renderer.render(camera).colour, colour)

    # Gaussians of the second part, 620 from number 1000 of the whole on.
    wanted["means"][1100:1400] += np.float32(0.3)
    placing.update_scene(1, 100, means=wanted["means"][1100:1400])
    check()
    wanted["opacities"][:50] = 0.5
    wanted["sh_rest"][:50] = arrays["sh_rest"][::-1][:50]
    other.update_scene(opacities=np.full(50, 0, np.float32), sh_rest=wanted["sh_rest"][:50], logit_opacities=True)
    check()
    wanted["scales"][1700:1710] = 0.25
    wanted["rotations"][1700:1710] = (1, 0, 0, 0)
    padded = np.zeros((10, 7), np.float32)
    padded[:, 1] = 3
    placing.update_scene(2, 80, scales=np.full((10, 3), np.log(np.float32(0.25)), np.float32),
                         rotations=padded[:, 1:5], log_scales=True)
    check()
    wanted["sh0"][:1000] = 0
    placing.update_scene(0, colours=np.full((1000, 3), 0.5, np.float32))
    check()


def test_updates_that_are_refused_change_nothing(placing, camera):
    wanted, means = placing.render(camera).colour, np.zeros((5, 3), np.float32)
    opacities, sh_rest = means[:, 0].copy(), np.zeros((5, 15, 3), np.float32)
    for scene, first, given, error, message in [
            (0, 0, {}, TypeError, "all arrays are None, expected one or more"),
            (3, 0, {"means": means}, swiftgs.InvalidArgument, "the scene is number 3, expected less than 3"),
            (-1, 0, {"means": means}, ValueError, "update_scene: scene is -1, expected 0 or more"),
            (0, -1, {"means": means}, ValueError, "update_scene: first is -1, expected 0 or more"),
            (0, 996, {"means": means}, swiftgs.InvalidArgument, "5 Gaussians from number 996 on, expected some"),
            (0, 0, {"means": means[:, :2]}, ValueError, "means has the shape (5, 2), expected (N, 3)"),
            (0, 0, {"means": [[0, 0, 0]]}, TypeError, "means is of type list"),
            (0, 0, {"means": means, "opacities": opacities[:4]}, ValueError,
             "opacities has the shape (4,), expected (5)"),
            (0, 0, {"means": means, "sh_rest": sh_rest[:, :8]}, swiftgs.InvalidArgument,
             "update: sh_degree is 2, expected 3 as in the scene"),
            (0, 0, {"means": means, "sh0": means, "colours": means}, TypeError, "takes either sh0 or colours"),
            (0, 0, {"sh_rest": sh_rest, "features": means[:4]}, ValueError,
             "features has the shape (4, 3), expected (5, N)")]:
        with pytest.raises(error, match=re.escape(message)):
            placing.update_scene(scene, first, **given)
    assert np.array_equal(placing.render(camera).colour, wanted)


def test_recorded_frames_follow_what_is_written_to_their_poses(placing, camera):
    placing.place([Placement(0), Placement(1, pose(0.5, (0.2, 0, 0.1), 0.3), opacity=0.75), Placement(2)])
    wanted = placing.render(camera, depth=True)
    frame = swiftgs.Frame.empty(WIDTH, HEIGHT, depth=True)
    with pytest.raises(ValueError, match="record: nothing was reserved, expected Renderer.reserve before"):
        placing.record()
    with pytest.raises(swiftgs.OrderError, match="recorded_scenes: expected reserve of placed scenes before"):
        placing.recorded_scenes  # pylint: disable=pointless-statement
    placing.reserve(camera, frame, splats=4000, intersections=400_000)
    placing.record()
    assert np.array_equal(frame.colour, wanted.colour) and np.array_equal(frame.depth, wanted.depth)
    report = placing.report
    assert 100 < report.visible <= 2000 < report.intersections and report.overflowed is False

    scenes = placing.recorded_scenes
    assert [array.shape for array in scenes] == [(3, 3, 3), (3,), (3, 3), (3,), (3, 4)]
    assert np.allclose(scenes.rotations[1] * scenes.scales[1], pose(0.5, angle=0.3)[:3, :3])
    assert scenes.translations.tolist() == [[0, 0, 0], [0.2, 0, 0.1], [0, 0, 0]]
    assert scenes.opacities.tolist() == [1, 0.75, 1] and scenes.tints.tolist() == [[1, 1, 1, 0]] * 3
    moved = pose(1.25, (-0.3, 0.2, 0), -0.4)
    placing.place([Placement(0, moved, opacity=0.5), Placement(1, pose(0.5, (0.2, 0, 0.1), 0.3)),
                   Placement(2, tint=Tint((0, 2, 0.5), 0.75))])
    wanted = placing.render(camera).colour
    placing.record()
    assert not np.array_equal(frame.colour, wanted)
    scenes.rotations[0], scenes.scales[0] = moved[:3, :3] / 1.25, 1.25
    scenes.translations[0], scenes.opacities[:2] = moved[:3, 3], (0.5, 1)
    scenes.tints[2] = 0, 2, 0.5, 0.75
    placing.record()
    assert decibels(frame.colour, wanted) > 80 and placing.refused_scenes == []
    placing.set_recorded_scenes()
    placing.record()
    assert np.array_equal(frame.colour, wanted)

    scenes.rotations[2, 0, 0] = 2
    with pytest.raises(swiftgs.InvalidArgument, match="expected a rotation with orthonormal columns"):
        placing.record()
    placing.set_recorded_scenes()
    other = swiftgs.Frame.empty(WIDTH, HEIGHT, depth=True)
    placing.set_views(swiftgs.Camera.builtin(WIDTH, HEIGHT), other)
    placing.record()
    assert np.array_equal(other.colour, wanted)
    placing.reserve(camera, frame, splats=5)
    with pytest.raises(ValueError, match="report: nothing was recorded, expected"):
        placing.report  # pylint: disable=pointless-statement
    placing.record()
    assert placing.report.overflowed and placing.report.visible > 5
    placing.trim()
    with pytest.raises(ValueError, match="report: nothing was recorded, expected"):
        placing.report  # pylint: disable=pointless-statement


def test_placements_tell_how_many_splats_they_have(placing, renderer, camera):
    with pytest.raises(swiftgs.OrderError, match="visible_by_scene: expected a frame before"):
        placing.visible_by_scene  # pylint: disable=pointless-statement
    placing.place([Placement(2), Placement(0, opacity=0), Placement(1), Placement(1, first=100, count=50)])
    placing.render(camera)
    visible = placing.visible_by_scene
    assert len(visible) == 4 and sum(visible) == placing.statistics.visible
    assert visible[1] == 0 < visible[3] <= 50 < visible[2] <= 620 and visible[0] > 100
    renderer.render(camera)
    assert renderer.visible_by_scene == [renderer.statistics.visible]
    placing.place([Placement(2)])
    with pytest.raises(swiftgs.InvalidArgument, match="visible_by_scene: count is 1, expected 4, the placed scenes"):
        placing.visible_by_scene  # pylint: disable=pointless-statement
