// SPDX-License-Identifier: Apache-2.0

// Compiled with -ffast-math, as a program of a user may be that includes the library's headers.
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stdexcept>

#include <doctest/doctest.h>

#include <swiftgs/swiftgs.hpp>

#include "policies/tile_lists.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// Checks that lists of many splats stay within the tiles and the splats that there are.
template <class Sort, class Bounds>
void check_lists(std::uint64_t seed) {
  const SplatSet splats = random_splats(4000, 300, 200, seed);
  const SortInput job = splats.job(300, 200);
  Serial serial;
  Sort sort;
  typename Sort::template Scratch<Serial> scratch;
  TileLists<Serial> lists;
  build_again<Bounds>(serial, sort, job, scratch, lists);
  std::size_t listed = 0, strange = 0;
  for (std::size_t tile = 0; tile < job.grid.size(); ++tile) {
    const TileRange range = lists.view().ranges[tile];
    strange += range.begin > range.end || range.end > lists.intersections;
    for (std::uint32_t at = range.begin; at < range.end; ++at, ++listed)
      strange += lists.view().ids[at] >= splats.shapes.size();
  }
  CHECK(strange == 0);
  CHECK(listed == lists.intersections);
  CHECK(lists.intersections > splats.shapes.size());
}

}  // namespace

TEST_CASE("fast math: tile lists name tiles and splats that there are") {
  for_each_type(AllBounds(), []<class Bounds>(Bounds) {
    CAPTURE(Bounds::name);
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      check_lists<EarlySort, Bounds>(seed);
      check_lists<StandardSort, Bounds>(seed);
    }
  });
}

TEST_CASE("fast math: numbers that are not finite are refused") {
  // As bits: to return such a number from a function is undefined here.
  for (const std::uint32_t bits : {0x7fc00000u, 0x7f800000u, 0xff800000u}) {
    Scene scene = random_scene(10, 1, 1);
    std::memcpy(&scene.sh_rest[7], &bits, sizeof bits);
    CHECK_THROWS_AS((void)Serial().upload(scene), std::invalid_argument);
  }
  Camera usual;
  usual.width = usual.height = 4;
  usual.fx = usual.fy = 4;
  CHECK_NOTHROW(validate(usual));
  for (const std::uint64_t bits : {0x7ff8000000000000u, 0x7ff0000000000000u, 0xfff0000000000000u}) {
    CAPTURE(bits);
    const auto refused = [&](const auto& member) {
      Camera camera = usual;
      std::memcpy(&member(camera), &bits, sizeof bits);
      CHECK_THROWS_AS(validate(camera), std::invalid_argument);
    };
    refused([](Camera& c) -> double& { return c.fy; });
    refused([](Camera& c) -> double& { return c.cx; });
    refused([](Camera& c) -> double& { return c.rotation[1][2]; });
    refused([](Camera& c) -> double& { return c.translation[1]; });
    refused([](Camera& c) -> double& { return c.lens.distortion.radial[1]; });
    double scale;
    std::memcpy(&scale, &bits, sizeof bits);
    CHECK_THROWS_AS((void)scaled(usual, scale), std::invalid_argument);
  }
}
