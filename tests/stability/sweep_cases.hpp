// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// All stability tests of whatever backends the including file has. It defines SWIFTGS_STABILITY, what the
/// names of the cases begin with, and in `swiftgs::test` a function `unavailable` that skips the case where
/// the backends cannot run, and a class `Backends` with the members of `Sweep`.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "stability/edge_cases.hpp"
#include "stability/found_cases.hpp"
#include "stability/number_cases.hpp"

namespace swiftgs::stress {

/// A bright opaque layer behind so many equal ones that pixels stop at it, and as many again behind it.
inline StressCase deep_stops(double layers, std::uint64_t seed, ImageSize size) {
  Random random(seed);
  StressCase out;
  out.camera = forward_camera(size, usual_focal(size));
  out.conventions.alpha_min = 1e-5f;
  const float opacity = float(1 - std::pow(2 * double(out.conventions.stop), 1 / layers));
  const auto layer = [&](double depth, float alpha, vec3 rgb) {
    add(out.scene, {.mean = {0, 0, float(depth)}, .scale = vec3(1000), .opacity = alpha, .rgb = rgb});
  };
  const vec3 rgb = random_colour(random);
  for (int i = 0; i < 2 * int(layers); ++i)
    layer(2 + (i + (i >= int(layers) ? 0.5 : 0)) / layers, opacity, rgb);
  layer(3, 0.99f, vec3(1000));
  return out;
}

/// As `on_ties`, behind, at and before an occluder.
inline StressCase on_occluders(double steps, std::uint64_t seed, ImageSize size) {
  StressCase out = on_ties(steps, seed, size);
  Random random(seed + 1);
  for (int i = 0; i < size.width * size.height; ++i)
    out.occluder.push_back(i % 7 == 0 ? std::numeric_limits<float>::infinity()
                                      : stepped(float(3 + i % 3), either_side(random, steps)));
  return out;
}

}  // namespace swiftgs::stress

namespace swiftgs::test {
namespace {

using Names = std::vector<std::string_view>;
using Seeds = std::vector<std::uint64_t>;

const Names long_shapes{"needles", "bare-needles", "pancakes", "ridges", "little-blur"};
const Names large_shapes{"grazing", "scales", "distant-means"};
const Names cameras{"wide-angles",   "long-lenses",     "principal-points", "uneven-focals",
                    "world-offsets", "distant-cameras", "skewed-rotations"};
const Names placed{"placed-scenes", "far-millimetres", "clipped-scenes"};
const Names lenses{"distorted-lenses", "fisheyes", "orthographic", "panoramas"};
const Names thresholds{"on-planes", "on-alphas", "on-stops", "on-ties"};
const Names stacks{"equal-stacks", "deep-stacks"};
const Names values{"harmonics", "backgrounds", "far-depths", "mixtures"};

/// Draws the families that are named. Two seeds of each are enough for sanitizers to see every path.
void sweep(const Names& names, Seeds seeds, ImageSize size) {
  if (unavailable()) return;
#ifdef __SANITIZE_ADDRESS__
  seeds.resize(std::min<std::size_t>(seeds.size(), 2));
#endif
  Backends backends;
  for_each_case(names, seeds, size, [&](StressCase drawn, Limits limits) {
    CaseJudge judge(std::move(drawn));
    backends.check(judge, Extent::all, limits);
  });
}

void check_one(StressCase drawn, Limits limits = {}) {
  check_drawn(std::move(drawn), Extent::rasterizers, limits);
}

TEST_CASE(SWIFTGS_STABILITY ": every family is swept") {
  std::set<std::string_view> swept;
  for (const Names& names : {long_shapes, large_shapes, cameras, placed, lenses, thresholds, stacks, values})
    swept.insert(names.begin(), names.end());
  for (const StressFamily& family : stress_families()) CHECK(swept.count(family.name) == 1);
  CHECK(swept.size() == stress_families().size());
}

TEST_CASE(SWIFTGS_STABILITY ": long thin shapes are drawn as exactly as floats allow") {
  sweep(long_shapes, {1, 2, 35, 36, 37, 38}, {});
}

TEST_CASE(SWIFTGS_STABILITY ": large and distant shapes are drawn as exactly as floats allow") {
  sweep(large_shapes, {3, 14, 40, 41, 42}, {});
}

TEST_CASE(SWIFTGS_STABILITY ": hard cameras are drawn as exactly as floats allow") {
  sweep(cameras, {5, 6, 27, 28, 29}, {});
}

TEST_CASE(SWIFTGS_STABILITY ": placed scenes are drawn as exactly as floats allow") {
  sweep(placed, {5, 6, 27, 28, 29}, {});
}

TEST_CASE(SWIFTGS_STABILITY ": lenses are drawn as exactly as floats allow") {
  sweep(lenses, {5, 6, 27, 28, 30}, {});
}

TEST_CASE(SWIFTGS_STABILITY ": decisions on an edge are taken as exactly as floats allow") {
  sweep(thresholds, {7, 8, 9, 10, 12, 13, 14}, {});
}

TEST_CASE(SWIFTGS_STABILITY ": stacks of layers are drawn as exactly as floats allow") {
  sweep(stacks, {11, 12}, {});
}

TEST_CASE(SWIFTGS_STABILITY ": pixels stop before a bright layer behind many faint ones") {
  for (const double layers : {10, 100, 600, 3000, 9000}) {
    CAPTURE(layers);
    check_one(stress::deep_stops(layers, 48, {16, 16}));
  }
}

TEST_CASE(SWIFTGS_STABILITY ": extreme values are drawn as exactly as floats allow") {
  sweep(values, {13, 16, 44, 45, 46, 47}, {});
}

TEST_CASE(SWIFTGS_STABILITY ": images that end within a tile are drawn as exactly as floats allow") {
  for (const Names& names : {long_shapes, large_shapes, cameras, placed, thresholds, values}) {
    sweep(names, {17}, {33, 17});
    sweep(names, {18}, {200, 3});
  }
}

TEST_CASE(SWIFTGS_STABILITY ": an occluder ends pixels as exactly as floats allow") {
  if (unavailable()) return;
  Backends backends;
  for (const double steps : {0.0, 1.0, 2.0, 4.0})
    for (const std::uint64_t seed : {19u, 20u, 21u}) {
      CAPTURE(steps);
      CAPTURE(seed);
      CaseJudge judge(stress::on_occluders(steps, seed, {}));
      backends.check(judge, Extent::all);
    }
}

TEST_CASE(SWIFTGS_STABILITY ": squares of three sigmas are drawn as exactly as floats allow") {
  if (unavailable()) return;
  Backends backends;
  for_each_case({}, {22}, {}, [&](StressCase drawn, Limits) {
    drawn.conventions.footprint = Conventions::Footprint::three_sigma_square;
    CaseJudge judge(std::move(drawn));
    backends.check_square(judge);
  });
}

#ifndef __SANITIZE_ADDRESS__  // a large image has no other paths
TEST_CASE(SWIFTGS_STABILITY ": needles of ratio 1e4 across a large image") {
  check_one(stress::needles(1e4, 23, {960, 540}), {120, 1.0 / 255});
}

TEST_CASE(SWIFTGS_STABILITY ": ridges of 1e4 pixels across a large image") {
  check_one(stress::ridges(1e4, 24, {960, 540}), {115, 1.0 / 255});
}

TEST_CASE(SWIFTGS_STABILITY ": ridges of 1e3 pixels across a large image of 1920x1080") {
  check_one(stress::ridges(1e3, 30, {1920, 1080}), {115, 1.0 / 255});
}
#endif

TEST_CASE(SWIFTGS_STABILITY ": a focal length of a thousandth of a pixel is drawn as usual ones are") {
  for (const std::uint64_t seed : {31u, 32u, 33u}) {
    CAPTURE(seed);
    check_one(stress::wide_angles(1e3, seed, {}), {130, 1e-5});
  }
}

TEST_CASE(SWIFTGS_STABILITY
          ": a principal point ten million pixels away is drawn as usual ones are where no decision flips") {
  // Of most or all pixels of these the judge leaves everything open; the limits do not.
  for (const std::uint64_t seed : {2u, 3u, 4u, 8u}) {
    CAPTURE(seed);
    check_one(stress::principal_points(1e7, seed, {}), {130, 1e-5});
  }
}

TEST_CASE(SWIFTGS_STABILITY ": an image one pixel high and as wide as images may be") {
  check_one(stress::needles(1e2, 25, {max_image_side, 1}));
  check_one(stress::mixtures(200, 26, {max_image_side, 1}));
}

}  // namespace
}  // namespace swiftgs::test
