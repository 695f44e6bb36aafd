// SPDX-License-Identifier: Apache-2.0

// Stages called one by one: what projection found holds for its bounds and its grid alone.
#include <stdexcept>

#include <doctest/doctest.h>

#include "policies/backends.hpp"
#include "policies/tile_lists.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// What projecting for an image leaves behind.
template <class B>
struct Projected {
  Projected(B& backend, int width, int height) {
    const Camera camera = forward_camera(width, height);
    const Scene scene = random_scene(500, 0, 3);
    project(backend,
            ProjectJob{view_constants(camera, Conventions::gsplat()), swiftgs::view(scene),
                       TileGrid::covering(width, height)},
            Ellipse{}, scratch, splats, footprints);
  }
  SortJob<Ellipse> job(TileGrid grid) const { return {splats.view(), grid, {}, footprints.view()}; }

  ProjectScratch<B> scratch;
  Splats<B> splats;
  Footprints<B, Ellipse> footprints;
};

}  // namespace

TEST_CASE_TEMPLATE("footprints: a sort takes those of its own grid and refuses others", B,
                   SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  const Projected<B> projected(backend, 100, 70);
  const TileGrid own = TileGrid::covering(100, 70), other = TileGrid::covering(70, 100);
  REQUIRE(projected.splats.count > 50);
  const auto check = [&]<class Sort>(Sort sort) {
    CAPTURE(Sort::name);
    typename Sort::template Scratch<B> scratch;
    TileLists<B> lists;
    CHECK_THROWS_WITH_AS(sort.build(backend, projected.job(other), Ellipse{}, scratch, lists),
                         "sort: the splats were projected for 7 x 5 tiles, expected the grid of the sort, "
                         "5 x 7 tiles",
                         std::invalid_argument);
    sort.build(backend, projected.job(own), Ellipse{}, scratch, lists);
    CHECK(to_vectors(lists.view()) == brute_force_lists<Ellipse>({projected.splats.view(), own, {}}));
  };
  check(StandardSort()), check(EarlySort()), check(AdaptiveSort());
}

TEST_CASE_TEMPLATE("footprints: those of another number of splats are refused", B, SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  const SplatSet splats = random_splats(20, 64, 48, 1);
  SortJob<Ellipse> job = splats.job(64, 48).within(Ellipse{});
  const Footprint some[3];
  job.footprints = {.each = {some, 3}, .instances = 3, .grid = job.grid};
  EarlySort::Scratch<B> scratch;
  TileLists<B> lists;
  CHECK_THROWS_WITH_AS(EarlySort().build(backend, job, Ellipse{}, scratch, lists),
                       "sort: there are footprints of 3 splats, expected those of 20", std::invalid_argument);
}
