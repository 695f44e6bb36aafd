# SPDX-License-Identifier: Apache-2.0
"""Placed scenes: several scenes in one frame."""
import gc

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
    wanted = renderer.render(camera).colour
    for placements in ([Placement(0), Placement(1), Placement(2)],
                       [Placement(k, np.eye(4), 1.0, Clip(radius=np.inf)) for k in range(3)]):
        placing.place(placements)
        assert np.array_equal(placing.render(camera).colour, wanted)
    assert placing.statistics.gaussians == 2000
    assert repr(placing).endswith(", 2,000 Gaussians in 3 placed scenes>")
    placing.set_scene(swiftgs.Scene.builtin(2000))
    assert np.array_equal(placing.render(camera).colour, wanted)
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


def test_placements_show_ranges_of_a_scene(renderer, camera):
    renderer.place([Placement(first=256, count=1000), Placement(first=1500), Placement(count=3)])
    found = renderer.render(camera).colour
    assert repr(renderer).endswith(", 1,503 Gaussians in 3 placed scenes>")
    placement, index = renderer.placed_scene_of([0, 999, 1000, 1499, 1500, 1502, NOTHING])
    assert placement.tolist() == [0, 0, 1, 1, 2, 2, -1] and index.tolist() == [256, 1255, 1500, 1999, 0, 2, -1]
    other = swiftgs.Renderer("cpu")
    other.share_scene(renderer)
    assert np.array_equal(other.render(camera).colour, found) and other.placed_scene_of(1000)[1] == 1500


def test_clips_choose_what_shows(renderer, scene, camera, expected):
    means, low, high = scene.means, np.array([-0.6, -1, -1.5]), np.array([0.4, 0.5, 0.3])
    for clip, chosen in [
            (Clip.box(low, high), ((means >= low) & (means <= high)).all(axis=1)),
            (Clip([[1, 0.5, 0, 0.1], [0, 0, -1, 0]], (0, 0, 0), 3),
             (means @ [1, 0.5, 0] + 0.1 >= 0) & (means[:, 2] <= 0) & ((means ** 2).sum(axis=1) <= 9))]:
        renderer.place([Placement(clip=clip)])
        found = renderer.render(camera).colour
        wanted = swiftgs.Renderer("cpu", scene=part_of(scene, chosen)).render(camera).colour
        assert np.array_equal(found, wanted) and not np.array_equal(found, expected.colour)


def test_opacities_and_tints_reach_the_frame(renderer, camera, expected):
    renderer.place([Placement(opacity=0)])
    assert renderer.render(camera, alpha=True).alpha.max() == 0
    renderer.place([Placement(tint=Tint(np.array([0.25, 0, 2]), np.float32(1)))])
    whole = renderer.render(camera, alpha=True)
    assert np.array_equal(whole.alpha, expected.alpha)
    assert np.allclose(whole.colour, whole.alpha[..., None] * np.float32([0.25, 0, 2]), rtol=1e-5, atol=1e-6)


def test_images_show_ranges_of_placed_scenes(placing, camera):
    wanted = []
    for some in ([0], [1, 2], [0, 1, 2]):
        placing.place([Placement(number) for number in some])
        wanted.append(placing.render(camera).colour)
    frame = placing.render([camera] * 3, shows=[range(0, 1), range(1, 3), None])
    assert frame.shows == [range(0, 1), range(1, 3), None] and np.array_equal(frame.colour, wanted)
    frame.shows = range(1, 3)
    placing.render([camera] * 3, out=frame)
    assert all(np.array_equal(found, wanted[1]) for found in frame.colour)
    frame.shows = None
    assert frame.shows == [None] * 3


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


def test_recorded_frames_follow_what_is_written_to_their_poses(placing, camera):
    placing.place([Placement(0), Placement(1, pose(0.5, (0.2, 0, 0.1), 0.3), opacity=0.75), Placement(2)])
    wanted = placing.render(camera, depth=True)
    frame = swiftgs.Frame.empty(WIDTH, HEIGHT, depth=True)
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
    for forget in (lambda: placing.reserve(camera, frame, splats=5), placing.trim):
        forget()
        with pytest.raises(ValueError, match="report: nothing was recorded, expected"):
            placing.report  # pylint: disable=pointless-statement


def test_placements_tell_how_many_splats_they_have(placing, camera):
    placing.place([Placement(2), Placement(0, opacity=0), Placement(1), Placement(1, first=100, count=50)])
    placing.render(camera)
    visible = placing.visible_by_scene
    assert len(visible) == 4 and visible[1] == 0 and sum(visible) == placing.statistics.visible
    placing.place([Placement(2)])
    with pytest.raises(swiftgs.InvalidArgument, match="visible_by_scene: count is 1, expected 4, the placed scenes"):
        placing.visible_by_scene  # pylint: disable=pointless-statement
