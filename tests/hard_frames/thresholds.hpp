// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "hard_frames/case.hpp"

/// @file
/// Families that stand on a threshold. Severity: how many of float's last places they lie off it.

namespace swiftgs::stress {

/// `value`, `steps` of float's last places away.
inline float stepped(float value, int steps) {
  for (; steps > 0; --steps) value = std::nextafter(value, std::numeric_limits<float>::infinity());
  for (; steps < 0; ++steps) value = std::nextafter(value, -std::numeric_limits<float>::infinity());
  return value;
}

/// -steps, 0 or steps.
inline int either_side(Random& random, double steps) { return (random.below(3) - 1) * int(steps); }

/// A Gaussian so large that alpha is its opacity all over the image.
inline Gaussian flat_gaussian(Random& random, ImageSize size, float z, float opacity) {
  const float side = float(1e4 * size.width * double(z) / usual_focal(size));
  return {.mean = {0, 0, z}, .scale = {side, side, 0}, .opacity = opacity, .rgb = random_colour(random)};
}

/// Depths at the near and far plane, off by whole last places or, through the camera's translation, by
/// halves.
inline StressCase on_planes(double steps, std::uint64_t seed, ImageSize size) {
  Random random(seed);
  StressCase out;
  if (seed % 2) out.conventions = Conventions::inria(), out.conventions.footprint = {};
  if (seed % 4 >= 2) out.conventions.far_plane = 37.3f;
  const float near = out.conventions.near_plane, far = std::fmin(out.conventions.far_plane, 1e9f);
  out.camera = forward_camera(size, usual_focal(size));
  for (int i = 0; i < 40; ++i) {
    const float z = stepped(i % 4 ? near : far, either_side(random, steps));
    Gaussian g = usual_gaussian(random, size);
    const float nearer = z / g.mean.z;
    g.mean = vec3(g.mean.x * nearer, g.mean.y * nearer, z);
    g.scale *= nearer;
    add(out.scene, g);
  }
  // Half a last place of the near plane, to either side.
  const double half = 0.5 * (double(stepped(near, 1)) - double(near));
  out.camera.translation.z = half * (seed % 3 == 0 ? 0.999 : seed % 3 == 1 ? -0.999 : 0);
  return out;
}

/// Alphas at the least and the largest that the conventions know.
inline StressCase on_alphas(double steps, std::uint64_t seed, ImageSize size) {
  Random random(seed);
  StressCase out = usual_case(random, size, 20);
  const float least[] = {1.0f / 255, 1e-3f, 0.25f, 0x1p-20f};
  out.conventions.alpha_min = least[seed % 4];
  out.conventions.alpha_max = seed % 3 ? 0.99f : 0.5f;
  for (int i = 0; i < 30; ++i) {
    const float at = i % 3 ? out.conventions.alpha_min : out.conventions.alpha_max;
    const float opacity = stepped(at, either_side(random, steps));
    if (i % 2) {
      add(out.scene, flat_gaussian(random, size, random.f(2, 10), opacity));
    } else {
      Gaussian g = usual_gaussian(random, size);
      g.opacity = opacity;
      add(out.scene, g);
    }
  }
  return out;
}

/// Transmittances at the stop.
inline StressCase on_stops(double steps, std::uint64_t seed, ImageSize size) {
  Random random(seed);
  StressCase out = usual_case(random, size, 30);
  for (vec3& mean : out.scene.means) mean = mean * 4.0f;  // behind what follows, mostly
  for (vec3& scale : out.scene.scales) scale *= 4.0f;
  out.conventions.stop_at_equal = seed % 2;
  if (seed % 3 == 0) out.conventions.stop = 0.0625f;
  const double left = double(out.conventions.stop);
  const int layers = 2 + int(seed % 5);
  const float opacity = float(1 - std::pow(left, 1.0 / layers));
  for (int i = 0; i < layers; ++i)
    add(out.scene,
        flat_gaussian(random, size, 1.0f + 0.125f * float(i), stepped(opacity, either_side(random, steps))));
  return out;
}

/// Depths equal to each other; for every third seed but for the rounding of a turned world, which orders
/// them.
inline StressCase on_ties(double steps, std::uint64_t seed, ImageSize size) {
  Random random(seed);
  StressCase out;
  out.camera = forward_camera(size, usual_focal(size));
  for (int i = 0; i < 60; ++i) {
    Gaussian g = usual_gaussian(random, size);
    const float z = stepped(float(3 + i / 20), either_side(random, steps));
    g.mean = point_in_view(random, size, double(z));
    g.mean.z = z, g.opacity = random.f(0.2, 0.9);
    add(out.scene, g);
  }
  if (seed % 3 == 0) turn(out, random.in(-3, 3));
  return out;
}

}  // namespace swiftgs::stress
