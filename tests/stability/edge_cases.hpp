// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Decisions on exact values, where no rounding excuses another outcome. For whatever backends the including
/// file has, as in `sweep_cases.hpp`.

#include <cmath>
#include <cstddef>
#include <limits>
#include <string_view>
#include <vector>

#include "hard_frames/thresholds.hpp"
#include "stability/sweep.hpp"

namespace swiftgs::test {
namespace {

using StressGaussian = stress::Gaussian;

/// Column and row of the pixel whose centre is the mean of every splat here.
constexpr int centre = 8;

/// A case without splats, in which alphas, transmittances and logarithms of opacities are powers of 2.
StressCase exact_case() {
  StressCase out;
  out.camera = stress::forward_camera({40, 40}, 32);
  out.camera.cx = out.camera.cy = centre + 0.5;
  out.conventions.alpha_min = 0.25f, out.conventions.alpha_max = 1;
  out.background = vec3(0);
  return out;
}

/// A splat of some pixels around the centre.
StressGaussian dot(float z, float opacity, vec3 rgb = vec3(1)) {
  return {.mean = {0, 0, z}, .scale = vec3(0.1f * z), .opacity = opacity, .rgb = rgb};
}

/// Draws `drawn` with all renderers: the pixel at the centre must be of this colour and alpha.
void check_centre(const StressCase& drawn, vec3 rgb, float alpha) {
  if (unavailable()) return;
  Backends().for_each_frame(drawn, [&](std::string_view name, const Frame& frame) {
    CAPTURE(name);
    const std::size_t i = std::size_t(centre) * std::size_t(frame.width) + centre;
    for (std::size_t c = 0; c < 3; ++c) CHECK(std::abs(frame.colour[3 * i + c] - rgb[int(c)]) <= 1e-6f);
    CHECK(std::abs(frame.alpha[i] - alpha) <= 1e-6f);
    CHECK(is_finite(frame));
  });
}

/// Draws one splat: whether the centre shows it.
void check_shown(const StressCase& settings, const StressGaussian& splat, bool shown, float alpha = 0.5f) {
  StressCase drawn = settings;
  stress::add(drawn.scene, splat);
  check_centre(drawn, vec3(shown ? alpha : 0), shown ? alpha : 0);
}

float above(float v) { return stress::stepped(v, 1); }
float below(float v) { return stress::stepped(v, -1); }

TEST_CASE(SWIFTGS_STABILITY ": alpha that equals the least is kept and less is skipped") {
  for (const float alpha_max : {0.99f, 1.0f}) {
    CAPTURE(alpha_max);
    StressCase settings = exact_case();
    settings.conventions.alpha_max = alpha_max;
    check_shown(settings, dot(2, 0.25f), true, 0.25f);
    check_shown(settings, dot(2, below(0.25f)), false);
  }
}

TEST_CASE(SWIFTGS_STABILITY
          ": a transmittance that equals the stop ends the pixel where the preset says so") {
  StressCase drawn = exact_case();
  for (int i = 0; i < 4; ++i) stress::add(drawn.scene, dot(float(2 + i), 0.5f));
  drawn.conventions.stop = 0.125f;
  drawn.conventions.stop_at_equal = true;
  check_centre(drawn, vec3(0.75f), 0.75f);
  drawn.conventions.stop_at_equal = false;
  check_centre(drawn, vec3(0.875f), 0.875f);
}

TEST_CASE(SWIFTGS_STABILITY ": depths on a plane are drawn as the preset says") {
  StressCase settings = exact_case();
  settings.conventions.near_plane = 0.3f, settings.conventions.far_plane = 7.7f;
  for (const bool cull : {false, true}) {
    CAPTURE(cull);
    settings.conventions.cull_at_near = cull;
    check_shown(settings, dot(below(0.3f), 0.5f), false);
    check_shown(settings, dot(0.3f, 0.5f), !cull);
    check_shown(settings, dot(above(0.3f), 0.5f), true);
    check_shown(settings, dot(7.7f, 0.5f), true);
    check_shown(settings, dot(above(7.7f), 0.5f), false);
  }
}

TEST_CASE(SWIFTGS_STABILITY ": a clip shows a mean on its border and none beside it") {
  const auto check = [](const Clip& clip, float z, bool shown) {
    StressCase settings = exact_case();
    settings.clip = clip;
    check_shown(settings, dot(z, 0.5f), shown);
  };
  const Clip box = Clip::box(vec3(0, -1, 1.1f), vec3(1, 0, 3.3f)), ball = Clip::sphere(vec3(0), 2);
  for (const float z : {1.1f, 3.3f}) check(box, z, true);
  for (const float z : {below(1.1f), above(3.3f)}) check(box, z, false);
  check(Clip::box(vec3(0x1p-30f, -1, 1), vec3(1, 1, 3)), 2, false);
  check(Clip::box(vec3(-1, -1, 1), vec3(1, -0x1p-30f, 3)), 2, false);
  check(ball, 2, true);
  check(ball, above(2), false);
  check(Clip::sphere(vec3(0, 0, 2), 0), 2, true);
  check(Clip::sphere(vec3(0, 0, 2), 0), above(2), false);
  Clip both = ball;
  both.half_space_count = 1, both.half_spaces[0] = vec4(0.5f, 3, -1, 2);
  check(both, 2, true);
  check(both, above(2), false);
  both.half_spaces[0].w = below(2);
  check(both, 2, false);
  both.half_space_count = 0;  // does not count
  check(both, 2, true);
}

TEST_CASE(SWIFTGS_STABILITY ": with a near plane of 0 depths are drawn down to the least") {
  StressCase settings = exact_case();
  settings.conventions.near_plane = 0;
  for (const double focal : {32.0, 1e12}) {
    CAPTURE(focal);
    settings.camera.fx = settings.camera.fy = focal;
    for (const float z : {above(least_depth), below(least_depth), 1e-38f, 1e-40f, 0.0f}) {
      CAPTURE(z);
      StressGaussian splat = dot(z, 0.5f);
      splat.scale = vec3(float(3.2 * double(z) / focal));
      check_shown(settings, splat, z >= least_depth);
    }
  }
}

TEST_CASE(SWIFTGS_STABILITY ": equal depths are drawn by index and the least difference by depth") {
  const vec3 red(1, 0, 0), green(0, 1, 0);
  const vec3 red_first(0.5f, 0.25f, 0), green_first(0.25f, 0.5f, 0);
  const auto check_order = [&](float red_z, float green_z, vec3 rgb) {
    StressCase drawn = exact_case();
    stress::add(drawn.scene, dot(red_z, 0.5f, red)), stress::add(drawn.scene, dot(green_z, 0.5f, green));
    check_centre(drawn, rgb, 0.75f);
  };
  for (const float z : {0.02f, 1.5f, 2.0f, 3.0f, 1e4f}) {
    CAPTURE(z);
    check_order(z, z, red_first);
    check_order(above(z), z, green_first);
    check_order(stress::stepped(z, 2), above(z), green_first);
    check_order(above(z), stress::stepped(z, 2), red_first);
  }
  check_order(3, 1.5f, green_first);
  check_order(1.5f, 3, red_first);
  check_order(1e4f, 0.02f, green_first);
}

TEST_CASE(SWIFTGS_STABILITY ": compensation has the least value of the conventions") {
  StressCase settings = exact_case();
  settings.conventions.alpha_min = 0x1p-12f;
  settings.conventions.antialiased = true;
  settings.conventions.min_compensation = 0x1p-8f;
  StressGaussian point = dot(2, 0.5f);
  point.scale = vec3(0);
  check_shown(settings, point, true, 0x1p-5f);
}

TEST_CASE(SWIFTGS_STABILITY ": a splat reaches as far as its opacity over the least alpha says") {
  if (unavailable()) return;
  Backends backends;
  for (const float alpha_min : {1.0f / 255, 0x1p-8f, 1e-3f, 0.25f, 0x1p-60f})
    for (const float opacity : {0.25f, 0.3f, 0.7f, 0.99f, 1.0f}) {
      CAPTURE(alpha_min);
      CAPTURE(opacity);
      StressCase drawn = exact_case();
      drawn.conventions.alpha_min = alpha_min;
      stress::add(drawn.scene, dot(2, opacity));
      const double cutoff = std::log2(double(opacity) / double(alpha_min));
      for (const SplatShape& shape : backends.shapes(drawn))
        CHECK(std::abs(double(shape.cutoff) - cutoff) <= 0x1p-22 * (1 + cutoff));
    }
}

TEST_CASE(SWIFTGS_STABILITY ": bounds lose no pixel at which an ellipse ends") {
  if (unavailable()) return;
  Backends backends;
  stress::Random random(28);
  for (int round = 0; round < 40; ++round) {
    CAPTURE(round);
    StressCase drawn = exact_case();
    drawn.conventions.alpha_min = 1.0f / 255, drawn.conventions.stop = 0;
    for (int i = 0; i < 60; ++i) {
      // Ends, but for a few last places of its opacity, at the first or last pixel of a neighbouring tile.
      const double sigma = random.in(1, 6), away = i % 4 < 2 ? 8 : 9, variance = sigma * sigma + 0.3;
      const double opacity = std::exp(0.5 * away * away / variance) / 255;
      if (!(opacity < 1)) continue;
      StressGaussian g = dot(2, stress::stepped(float(opacity), random.below(7) - 3));
      g.scale = vec3(float(sigma * 2 / 32)), g.rgb = stress::random_colour(random);
      g.mean[i % 2] = away == 9 ? 1 : 0;
      g.mean[1 - i % 2] = float(random.below(20)) / 16;
      stress::add(drawn.scene, g);
    }
    backends.check_bounds(drawn);
  }
}

TEST_CASE(SWIFTGS_STABILITY ": the largest variance is drawn and a larger one is not") {
  const float largest = 1e18f;  // the root of the largest variance
  StressGaussian huge = dot(1, 0.5f);
  for (const int side : {0, 1}) {
    CAPTURE(side);
    huge.scale = vec3(0), huge.scale[side] = 0.99f * largest / 32;
    check_shown(exact_case(), huge, true);
    huge.scale[side] = 1.01f * largest / 32;
    check_shown(exact_case(), huge, false);
  }
}

TEST_CASE(SWIFTGS_STABILITY ": transmittance shows the background and negative colours are black") {
  StressCase drawn = exact_case();
  drawn.background = vec3(8, -4, 0.5f);
  stress::add(drawn.scene, dot(2, 0.75f, vec3(-1, 1, -0.01f)));
  check_centre(drawn, vec3(2, -0.25f, 0.125f), 0.75f);
}

TEST_CASE(SWIFTGS_STABILITY ": numbers that are not finite draw nothing and change nothing") {
  if (unavailable()) return;
  Backends backends;
  const float infinity = std::numeric_limits<float>::infinity(), nan = std::nanf("");
  const auto check_same = [&](const StressCase& with, const StressCase& without) {
    std::vector<Frame> expected;
    backends.for_each_frame(without, [&](std::string_view, const Frame& f) { expected.push_back(f); });
    std::size_t i = 0;
    backends.for_each_frame(with, [&](std::string_view name, const Frame& frame) {
      CAPTURE(name);
      CHECK(same_planes(frame, expected[i++]));
    });
  };
  for (const float wild : {infinity, -infinity, nan})
    for (int member = 0; member < 9; ++member) {
      CAPTURE(wild);
      CAPTURE(member);
      stress::Random random(27);
      StressCase without = stress::usual_case(random, {40, 40}, 40);
      StressGaussian g = dot(1, 0.9f);
      if (member < 3) g.mean[member] = wild;
      if (member == 3 || member == 4) g.scale[member - 3] = wild;
      if (member == 5) g.rotation.w = wild;
      if (member == 6) g.rotation.y = wild;
      if (member == 7) g.opacity = wild;
      if (member == 8) g.rgb.y = wild;
      StressCase with = without;
      stress::add(with.scene, g);
      check_same(with, without);
      with = without;
      stress::add(with.scene, dot(1, 0.9f));
      with.scene.sh_rest[with.scene.sh_rest.size() - 2] = wild;
      check_same(with, without);
    }
}

}  // namespace
}  // namespace swiftgs::test
