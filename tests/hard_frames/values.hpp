// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "hard_frames/case.hpp"

/// @file
/// Families of many layers, of extreme values, and of everything at once.

namespace swiftgs::stress {

/// Equal faint layers, never stopped; severity: how many.
inline StressCase equal_stacks(double layers, std::uint64_t seed, ImageSize size) {
  Random random(seed);
  StressCase out;
  out.camera = forward_camera(size, usual_focal(size));
  out.conventions.alpha_min = 1e-4f, out.conventions.stop = 0;
  const float opacity = float(random.in(2, 4) * 1e-4);
  const vec3 rgb = random_colour(random);
  for (int i = 0; i < int(layers); ++i)
    add(out.scene,
        {.mean = {0, 0, 4}, .scale = vec3(float(20 / usual_focal(size))), .opacity = opacity, .rgb = rgb});
  return out;
}

/// Unequal layers behind each other, stopped as usual; severity: how many.
inline StressCase deep_stacks(double layers, std::uint64_t seed, ImageSize size) {
  Random random(seed);
  StressCase out;
  out.camera = forward_camera(size, usual_focal(size));
  for (int i = 0; i < int(layers); ++i) {
    Gaussian g = usual_gaussian(random, size);
    g.scale = vec3(float(6 * double(g.mean.z) / usual_focal(size)));
    g.opacity = float(random.scale(1.01, 8) / 255);
    add(out.scene, g);
  }
  return out;
}

/// Harmonics of every degree, of degree 1 where sums of more would leave the range of float; severity: their
/// magnitude.
inline StressCase harmonics(double magnitude, std::uint64_t seed, ImageSize size) {
  Random random(seed);
  StressCase out = usual_case(random, size, 60, magnitude > 1e37 ? 1 : 1 + int(seed % 3));
  for (vec3& v : out.scene.sh0)
    v = {random.f(-magnitude, magnitude), random.f(-magnitude, magnitude), random.f(-magnitude, magnitude)};
  for (float& v : out.scene.sh_rest) v = random.f(-magnitude, magnitude);
  return out;
}

/// Bright and negative backgrounds; severity: their magnitude.
inline StressCase backgrounds(double magnitude, std::uint64_t seed, ImageSize size) {
  Random random(seed);
  StressCase out = usual_case(random, size);
  out.background = {random.f(0.5 * magnitude, magnitude), random.f(-magnitude, 0), random.f(0, magnitude)};
  return out;
}

/// A usual scene seen from ever further away, without a far plane; severity: depth.
inline StressCase far_depths(double depth, std::uint64_t seed, ImageSize size) {
  Random random(seed);
  StressCase out = usual_case(random, size, 60, 3);
  out.conventions = Conventions::inria(), out.conventions.footprint = {};
  for (vec3& mean : out.scene.means) mean *= float(depth);
  for (vec3& scale : out.scene.scales) scale *= float(depth);
  return out;
}

/// All at once, by chance; severity: how many Gaussians.
inline StressCase mixtures(double count, std::uint64_t seed, ImageSize size) {
  Random random(seed);
  StressCase out;
  out.camera = forward_camera(size, usual_focal(size) * random.scale(0.3, 10));
  const double side = random.in(-1, 1);
  out.camera.cx += side * random.scale(1, 500);
  out.camera.fy *= random.scale(0.5, 2);
  if (random.below(2)) out.conventions = Conventions::inria(), out.conventions.footprint = {};
  out.conventions.antialiased = random.below(2);
  if (random.below(3) == 0) out.conventions.blur = float(random.scale(1e-4, 1));
  out.scene.sh_degree = random.below(4);
  for (int i = 0; i < int(count); ++i) {
    Gaussian g = usual_gaussian(random, size);
    const double z = random.scale(0.02, 100), pixel = z / out.camera.fx;
    g.mean = {float((random.in(-0.2, 1.2) * size.width - out.camera.cx) * pixel),
              float((random.in(-0.2, 1.2) * size.height - out.camera.cy) * z / out.camera.fy), float(z)};
    for (int k = 0; k < 3; ++k) g.scale[k] = float(pixel * random.scale(1e-3, 1e3));
    if (random.below(8) == 0) g.scale[random.below(3)] = 0;
    if (random.below(8) == 0) {
      const float stretch = random.f(0.7, 1.3);
      g.rotation = {g.rotation.w * stretch, g.rotation.x * stretch, g.rotation.y * stretch,
                    g.rotation.z * stretch};
    }
    g.opacity = random.below(4) ? random.f(0.004, 0.5) : random.f(0.5, 1);
    add(out.scene, g);
  }
  for (float& v : out.scene.sh_rest) v = random.f(-0.3, 0.3);
  return out;
}

}  // namespace swiftgs::stress
