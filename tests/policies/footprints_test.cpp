// SPDX-License-Identifier: Apache-2.0

// Footprints: which tiles a splat may touch, found once and traversed where intersections are emitted.
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <hwy/targets.h>

#include "policies/backends.hpp"
#include "policies/only_targets.hpp"
#include "policies/tile_lists.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// Whether `backend` finds the footprints of the scalar bounds, on tiles of every kind of side.
template <class B>
void check_footprints_on(B& backend) {
  const SplatSet splats = random_splats(3001, 700, 500, 3);
  for (const int side : {16, 32, 64, 512})
    for_each_type(AllBounds(), [&]<class Bounds>(Bounds bounds) {
      CAPTURE(side);
      CAPTURE(Bounds::name);
      const TileGrid grid = TileGrid::covering(700, 500, side);
      const Binned<B, Bounds> binned(backend, splats.job(700, 500, side), bounds);
      const FootprintsView found = binned.footprints.view();
      REQUIRE(found.each.size == splats.shapes.size());
      CHECK(found.views.tiles == tiles_of_frame(binned.view));
      std::uint64_t intersections = 0, other = 0;
      for (std::size_t i = 0; i < found.each.size; ++i) {
        const Footprint expected = find_footprint(bounds, splats.shapes[i], grid);
        other += found.each[i].mask != expected.mask || found.each[i].count != expected.count ||
                 (expected.count != 0 && found.each[i].first != expected.first);
        intersections += expected.count;
      }
      CHECK(other == 0);
      CHECK(found.intersections.most == intersections);
    });
}

/// The same for two views whose splats take turns, of which the second shows a part of its image.
template <class B>
void check_footprints_of_views_on(B& backend) {
  const SplatSet set = random_splats(3001, 700, 500, 5);
  for (const int side : {16, 64})
    for_each_type(AllBounds(), [&]<class Bounds>(Bounds bounds) {
      CAPTURE(side);
      CAPTURE(Bounds::name);
      View views[] = {view_without_camera(700, 500, side), view_without_camera(300, 250, side)};
      views[1].grid.columns.begin += 2, views[1].grid.columns.end += 2;
      views[1].grid.rows.begin += 1, views[1].grid.rows.end += 1;
      number_tiles({views, 2});
      Splats<B> splats;
      CopySplats<B>::copy(set.view(), splats);
      splats.resize(splats.count, 2);
      for (std::size_t i = 0; i < splats.count; ++i) splats.of_view.data()[i] = i / 7 % 2;
      Footprints<B> footprints;
      bin(backend, plan_without_scene({views, 2}), bounds, splats, footprints);
      const FootprintsView found = footprints.view();
      REQUIRE(found.each.size == set.shapes.size());
      std::uint64_t intersections = 0, other = 0, in_part = 0;
      for (std::size_t i = 0; i < found.each.size; ++i) {
        const Footprint expected = find_footprint(bounds, set.shapes[i], views[i / 7 % 2].grid);
        other += found.each[i].mask != expected.mask || found.each[i].count != expected.count ||
                 (expected.count != 0 && found.each[i].first != expected.first);
        intersections += expected.count, in_part += i / 7 % 2 != 0 && expected.count != 0;
      }
      CHECK(other == 0);
      CHECK(found.intersections.most == intersections);
      CHECK(in_part > 300);
    });
}

}  // namespace

TEST_CASE_TEMPLATE("footprints: every backend finds those of the scalar bounds", B, SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  check_footprints_on(backend);
  check_footprints_of_views_on(backend);
}

TEST_CASE("footprints: every vector target finds those of the scalar bounds") {
  Cpu cpu(1);
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    CAPTURE(hwy::TargetName(target));
    const OnlyTargets only(target);
    check_footprints_on(cpu);
    check_footprints_of_views_on(cpu);
  }
}

TEST_CASE("footprints: a traversal names the tiles of the bounds once each and in order") {
  const SplatSet splats = random_splats(2000, 700, 500, 4);
  const TileGrid grid = TileGrid::covering(700, 500);
  std::size_t large = 0;
  for (const SplatShape& shape : splats.shapes) {
    const Footprint footprint = find_footprint(Ellipse(), shape, grid);
    large += footprint.mask == 0 && footprint.count != 0;
    std::vector<std::uint32_t> traversed, expected;
    for_each_tile(footprint, Ellipse(), shape, grid, [&](std::uint32_t tile) { traversed.push_back(tile); });
    const auto tiles = Ellipse().tiles(shape, grid);
    const TileRect& rect = tiles.rect;
    for (int row = rect.rows.begin; row < rect.rows.end && rect.columns.size() > 0; ++row) {
      const TileRun run = tiles.row(row);
      for (int column = run.begin; column < run.end; ++column)
        expected.push_back(std::uint32_t(row * grid.columns.size() + column));
    }
    REQUIRE(traversed == expected);
  }
  CHECK(large > 50);
}

TEST_CASE_TEMPLATE("footprints: those that say another number of intersections are refused", B,
                   SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  const SplatSet splats = random_splats(20, 64, 48, 1);
  const Binned<B, Ellipse> binned(backend, splats.job(64, 48), Ellipse{});
  SortJob job = binned.job();
  const std::string sum = std::to_string(job.footprints.intersections.most);
  job.footprints.intersections = 1;
  const std::string expected =
      "sort: the footprints hold " + sum + " intersections, expected those that they say, 1";
  const auto check = [&]<class Sort>(Sort sort) {
    typename Sort::template Scratch<B> scratch;
    TileLists<B> lists;
    CHECK_THROWS_WITH_AS(sort.build(backend, job, Ellipse{}, scratch, lists), expected.c_str(),
                         std::invalid_argument);
  };
  check(StandardSort()), check(EarlySort()), check(AdaptiveSort());
}

TEST_CASE_TEMPLATE("footprints: those of another number of splats are refused", B, SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  const SplatSet splats = random_splats(20, 64, 48, 1);
  const Footprint some[3];
  const View view = view_without_camera(64, 48);
  const SortJob job{splats.view(), {{some, 3}, 3, {&view, 1}}, {}};
  const auto check = [&]<class Sort>(Sort sort) {
    typename Sort::template Scratch<B> scratch;
    TileLists<B> lists;
    CHECK_THROWS_WITH_AS(sort.build(backend, job, Ellipse{}, scratch, lists),
                         "sort: there are footprints of 3 splats, expected those of 20",
                         std::invalid_argument);
  };
  check(StandardSort()), check(EarlySort()), check(AdaptiveSort());
}
