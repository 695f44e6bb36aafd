// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

#include "hard_frames/case.hpp"

/// @file
/// Families of lenses that are no pinholes.

namespace swiftgs::stress {

/// A Gaussian some pixels large in this direction from the camera at the origin.
inline void add_towards(Scene& scene, const Camera& camera, Random& random, dvec3 direction) {
  const double length =
      std::sqrt(direction.x * direction.x + direction.y * direction.y + direction.z * direction.z);
  const double distance = random.in(2, 10), pixel = distance / camera.fx;
  const auto side = [&] { return float(pixel * random.scale(0.5, 12)); };
  add(scene, {.mean = vec3(direction * (distance / length)),
              .scale = {side(), side(), side()},
              .rotation = random.rotation(),
              .opacity = float(random.scale(0.02, 1)),
              .rgb = random_colour(random)});
}

/// The direction at `polar` from the z axis. @units{radians}
inline dvec3 from_axis(double polar, double around) {
  return dvec3(std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around), std::cos(polar));
}

/// A factor a little below 1 or above: so near a fold-over derivatives vanish.
inline double about_1(Random& random) {
  const double off = random.scale(1e-4, 1e-2);
  return random.in(0, 2) < 1 ? 1 - off : 1 + off;
}

/// Barrel distortion with Gaussians to both sides of its fold-over; severity: the corner's distance from the
/// axis over that of the fold, both in the image.
inline StressCase distorted_lenses(double share, std::uint64_t seed, ImageSize size) {
  constexpr double pi = 3.141592653589793;
  Random random(seed);
  StressCase out;
  // r + k r^3 is largest, 2 r / 3, at r = fold.
  const double fold = random.in(0.5, 3), corner = 0.5 * std::hypot(size.width, size.height);
  out.camera = forward_camera(size, corner / (share * fold * 2 / 3));
  Distortion& d = out.camera.lens.distortion;
  d.radial[0] = -1 / (3 * fold * fold);
  if (seed % 2) d.tangential[0] = random.in(-1e-3, 1e-3), d.tangential[1] = random.in(-1e-3, 1e-3);
  if (seed % 3 == 0) d.rational[0] = random.in(0, 0.05), d.rational[1] = random.in(0, 0.01);
  if (seed % 5 == 0) out.conventions.clamp = Conventions::JacobianClamp::around_centre;
  out.conventions.antialiased = seed % 4 == 0;
  for (int i = 0; i < 60; ++i) {
    const double shown = i % 3 == 1 ? share : 1;
    const double tangent = fold * (i % 6 == 0   ? random.scale(0.9, 1.2)
                                   : i % 6 == 3 ? about_1(random)
                                                : shown * random.in(0, 1));
    add_towards(out.scene, out.camera, random, from_axis(std::atan(tangent), random.in(0, 2 * pi)));
  }
  return out;
}

/// Fisheye lenses; severity: the angle that the image shows from side to side. @units{degrees}
inline StressCase fisheyes(double degrees, std::uint64_t seed, ImageSize size) {
  constexpr double pi = 3.141592653589793;
  Random random(seed);
  StressCase out;
  const double half = degrees * pi / 360;
  out.camera = forward_camera(size, 0.5 * size.width / half);
  out.camera.lens.model = LensModel::fisheye;
  Distortion& d = out.camera.lens.distortion;
  double edge = half;
  if (seed % 2) {
    d.radial[0] = random.in(-0.02, 0.02), d.radial[1] = random.in(-0.002, 0.002);
    d.radial[2] = random.in(-1e-4, 1e-4), d.radial[3] = random.in(-1e-5, 1e-5);
  } else if (seed % 4 == 0) {  // folds within the field
    edge = random.in(0.5, 0.9) * half, d.radial[0] = -1 / (3 * edge * edge);
  }
  if (seed % 3 == 0) {
    for (double* term : {&d.prism[0], &d.prism[1], &d.tangential[1]}) *term = random.in(-1e-3, 1e-3);
  }
  if (seed % 5 == 0 && degrees < 170) out.conventions.depth = Conventions::Depth::z;
  for (int i = 0; i < 60; ++i) {
    // On the axis, at the edge of the field, and between.
    const double polar = i % 4 == 0   ? random.scale(1e-6, 0.1)
                         : i % 8 == 1 ? half * random.in(0.95, 1.1)
                         : i % 8 == 5 ? edge * about_1(random)
                                      : half;
    const double around = random.in(0, 2 * pi), off_axis = i % 4 < 2 ? polar : random.in(0, 1) * polar;
    add_towards(out.scene, out.camera, random, from_axis(off_axis, around));
  }
  return out;
}

/// Parallel rays; severity: depth over the width of what the image shows.
inline StressCase orthographic(double depth, std::uint64_t seed, ImageSize size) {
  Random random(seed);
  StressCase out;
  const double width = random.scale(0.1, 10), pixel = width / size.width;
  out.camera = forward_camera(size, 1 / pixel);
  out.camera.lens.model = LensModel::orthographic;
  for (int i = 0; i < 60; ++i) {
    const auto side = [&] { return float(pixel * random.scale(0.5, 12)); };
    add(out.scene, {.mean = {float(pixel * size.width * random.in(-0.6, 0.6)),
                             float(pixel * size.height * random.in(-0.6, 0.6)),
                             float(depth * width * random.in(0.5, 1))},
                    .scale = {side(), side(), side()},
                    .rotation = random.rotation(),
                    .opacity = float(random.scale(0.02, 1)),
                    .rgb = random_colour(random)});
  }
  return out;
}

/// Whole panoramas; severity: the inverse of the angle between a pole and the Gaussians near it. Others lie
/// at the seam, which is behind the camera. @units{1/radians}
inline StressCase panoramas(double inverse, std::uint64_t seed, ImageSize size) {
  constexpr double pi = 3.141592653589793;
  Random random(seed);
  StressCase out;
  out.camera = forward_camera(size, size.width / (2 * pi));
  out.camera.fy = size.height / pi;
  out.camera.lens.model = LensModel::equirectangular;
  for (int i = 0; i < 60; ++i) {
    const double around = random.in(0, 2 * pi);
    dvec3 direction = from_axis(random.in(0, pi), around);
    if (i % 3 == 0) {
      const double around_pole = random.in(0, 2 * pi);
      const dvec3 near = from_axis(random.scale(0.1, 1) / inverse, around_pole);
      direction = dvec3(near.x, i % 2 ? near.z : -near.z, near.y);
    }
    if (i % 3 == 1) {
      const double y = random.in(-1, 1), x = random.in(-1, 1) / inverse;
      direction = {x, y, -1};
    }
    add_towards(out.scene, out.camera, random, direction);
  }
  return out;
}

}  // namespace swiftgs::stress
