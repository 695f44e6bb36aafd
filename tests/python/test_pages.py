# SPDX-License-Identifier: Apache-2.0
"""Page files, drawn within a budget."""
import pathlib

import numpy as np
import pytest

import swiftgs

TREE = pathlib.Path(__file__).parents[1] / "fuzz/seeds/pages/tree.sgp"


@pytest.fixture
def pages():
    return swiftgs.open_pages(TREE)


def test_a_cut_is_drawn_and_named(pages, camera):
    assert (len(pages), pages.page_size) == (130, 128) and pages.pages > 1
    assert repr(pages) == f"<swiftgs.Pages 130 Gaussians in {pages.pages} pages>"
    assert np.less(pages.lower, pages.upper).all() and len(pages.origin) == 3
    renderer = swiftgs.Renderer("cpu")
    pool = swiftgs.PagePool(renderer, pages, bytes=10_000_000, estimate=10_000_000)
    cut = pool.cut(camera, pixels=0, ahead=camera)
    assert cut.splats == 65 and cut.missing > 0 and not cut.is_settled and cut.failure is None
    cut = pool.cut([camera, camera], pixels=0, wait=True)
    assert cut.is_settled and cut.splats == cut.wanted and cut.bytes <= 10_000_000 and cut.estimated_db == np.inf
    assert 0 < pool.cut(camera, pixels=1e9, wait=True).estimated_db < np.inf
    assert pool.cut(camera, pixels=0.01, wait=True).splats == 130
    assert pool.cut(camera, pixels=0.01, blend=1e300, wait=True).splats == 65  # children hardly show yet
    pool.cut(camera, pixels=0, wait=True)
    frame = renderer.render(camera, id=True)
    number = int(frame.id[frame.id != swiftgs.NOTHING][0])
    assert len(renderer.visible_by_scene) == cut.scenes > 1 and sum(renderer.visible_by_scene) > 0
    assert repr(renderer).endswith(", 130 Gaussians and nodes of pages>") and cut.splats == 130
    with pytest.raises(swiftgs.OrderError, match="PagePool.named"):
        renderer.placed_scene_of(number)
    named = pool.named(number)
    assert named.is_gaussian and named.scene == 0 and named.number < 130
    assert pool.cut(camera, splats=100, out=frame).wanted <= 100
    pool.place([swiftgs.Placement(opacity=0.5)])
    pool.cut(camera, pixels=0, wait=True)
    assert not np.array_equal(renderer.render(camera).colour, frame.colour)
    seen = renderer.render(camera).colour
    pool.close()
    np.zeros(10_000_000)  # may take the memory of freed pages
    assert np.array_equal(renderer.render(camera).colour, seen)
    with pytest.raises(swiftgs.OrderError, match="the pool is closed"):
        pool.cut(camera)


def test_what_cannot_be_pages_is_refused(pages, camera, tmp_path):
    with pytest.raises(swiftgs.FileError, match="none.sgp"):
        swiftgs.open_pages(tmp_path / "none.sgp")
    renderer = swiftgs.Renderer("cpu")
    with pytest.raises(swiftgs.InvalidType, match="pages"):
        swiftgs.PagePool(renderer, "tree.sgp")
    with pytest.raises(swiftgs.InvalidArgument, match="no pages"):
        swiftgs.PagePool(renderer, [])
    pool = swiftgs.PagePool(renderer, [pages])
    with pytest.raises(swiftgs.InvalidArgument, match="pixels is -1, expected 0 or more"):
        pool.cut(camera, pixels=-1)
    with pytest.raises(swiftgs.InvalidArgument, match="blend is -1, expected 0 or more"):
        pool.cut(camera, blend=-1)
    assert np.isnan(pool.cut(camera).estimated_db)
    with pytest.raises(swiftgs.InvalidArgument, match="number 1, expected less than 1"):
        pool.place([swiftgs.Placement(1)])


def test_scenes_of_its_own_show_again_and_are_shared(pages, camera):
    renderer, other = swiftgs.Renderer("cpu", scene=swiftgs.Scene.builtin(500)), swiftgs.Renderer("cpu")
    alone = renderer.render(camera).colour
    pool = swiftgs.PagePool(renderer, pages)
    pool.cut(camera, wait=True)
    other.share_scene(renderer)
    pool.close()
    assert np.array_equal(other.render(camera).colour, alone)
    assert other.placed_scene_of(499)[1] == 499
    renderer.place([swiftgs.Placement()])
    assert np.array_equal(renderer.render(camera).colour, alone)
    assert renderer.visible_by_scene == other.visible_by_scene and renderer.placed_scene_of(499)[1] == 499
