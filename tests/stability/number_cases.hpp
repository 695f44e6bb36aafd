// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Numbers that no trained scene has. For whatever backends the including file has, as in `sweep_cases.hpp`.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

#include "stability/sweep.hpp"

namespace swiftgs::test {
namespace {

void check_drawn(StressCase drawn, Extent extent = Extent::all, Limits limits = {}) {
  if (unavailable()) return;
  CaseJudge judge(std::move(drawn));
  Backends().check(judge, extent, limits);
}

const vec3 black(-0.1f);  // cut at 0

StressCase usual_scene(std::uint64_t seed, int count = 200) {
  stress::Random random(seed);
  return stress::usual_case(random, {96, 64}, count);
}

TEST_CASE(SWIFTGS_STABILITY ": scales of 0 and of 1e12 are drawn") {
  StressCase drawn = usual_scene(1);
  for (vec3& scale : drawn.scene.scales) scale = vec3(0);
  check_drawn(drawn);
  for (vec3& scale : drawn.scene.scales) scale = vec3(1e12f);
  check_drawn(drawn);
}

TEST_CASE(SWIFTGS_STABILITY ": scales whose squares no float holds are left out and nothing is infinite") {
  StressCase drawn = usual_scene(2);
  for (std::size_t i = 0; i < drawn.scene.size(); i += 3) drawn.scene.scales[i] = vec3(1e30f, 1e-30f, 1e25f);
  for (std::size_t i = 1; i < drawn.scene.size(); i += 3) drawn.scene.scales[i] = vec3(3e38f);
  check_drawn(drawn);
}

TEST_CASE(SWIFTGS_STABILITY ": opacities of 0 and 1 and between with denormal ones among them") {
  StressCase drawn = usual_scene(8);
  const float denormal = std::numeric_limits<float>::denorm_min(), least = std::numeric_limits<float>::min();
  const float alpha_min = 1.0f / 255, below = std::nextafter(alpha_min, 0.0f),
              above = std::nextafter(alpha_min, 1.0f);
  const float opacities[] = {0, 1, denormal, least / 3, alpha_min, below, above, std::nextafter(1.0f, 0.0f)};
  for (std::size_t i = 0; i < drawn.scene.size(); ++i) drawn.scene.opacities[i] = opacities[i % 8];
  check_drawn(drawn);
}

TEST_CASE(SWIFTGS_STABILITY ": alphas are shown down to the least that conventions may name") {
  for (const float alpha_min : {1e-10f, 1e-20f, 1e-30f, 0x1p-126f}) {
    CAPTURE(alpha_min);
    StressCase drawn = usual_scene(21);
    drawn.conventions.alpha_min = alpha_min;
    check_drawn(drawn);
    // One splat whose mean is off the image, so that pixels show its tail alone.
    drawn.scene = {};
    drawn.background = vec3(0);
    stress::add(drawn.scene, {.mean = {-2.2f, 0, 2}, .scale = vec3(0.1f), .opacity = 0.7f});
    check_drawn(drawn);
  }
}

TEST_CASE(SWIFTGS_STABILITY ": a colour that is finite is drawn though its terms or their sums are not") {
  StressCase drawn = usual_scene(22);
  Scene& scene = drawn.scene;
  const std::size_t rest = 3 * std::size_t(sh_rest_count(scene.sh_degree));
  const float largest = std::numeric_limits<float>::max();
  for (std::size_t i = 0; i < scene.size(); ++i) {
    scene.sh0[i] = vec3(i % 2 ? largest : 1e38f);
    for (std::size_t k = 0; k < rest; ++k)
      scene.sh_rest[i * rest + k] = (i >> k / 3 & 1 ? 1.0f : -1.0f) * (i % 3 ? largest : 1e38f);
  }
  check_drawn(drawn);
}

TEST_CASE(SWIFTGS_STABILITY ": depths that no float holds are not drawn") {
  StressCase drawn = usual_scene(13, 60);
  stress::turn(drawn, 0.7);
  for (std::size_t i = 0; i < drawn.scene.size(); i += 4) drawn.scene.means[i] = vec3(3e38f);
  for (const Conventions& conventions : {Conventions::gsplat(), Conventions::inria()}) {
    drawn.conventions = conventions, drawn.conventions.footprint = {};
    check_drawn(drawn);
  }
}

TEST_CASE(SWIFTGS_STABILITY ": transmittances keep their digits behind four black splats") {
  for (const float opacity : {1.0f, 0.983f, 0.97f, 0.6f}) {
    CAPTURE(opacity);
    stress::Random random(1);
    StressCase drawn = stress::usual_case(random, {96, 64}, 20);
    for (vec3& mean : drawn.scene.means) mean *= 4.0f;
    for (vec3& scale : drawn.scene.scales) scale *= 4.0f;
    drawn.conventions.stop = 1e-9f;
    for (int i = 0; i < 4; ++i) {
      stress::Gaussian g = stress::flat_gaussian(random, {96, 64}, random.f(1, 3), opacity);
      g.rgb = black;
      stress::add(drawn.scene, g);
    }
    check_drawn(drawn);
  }
}

}  // namespace
}  // namespace swiftgs::test
