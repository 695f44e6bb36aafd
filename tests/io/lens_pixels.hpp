// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/camera.hpp>
#include <swiftgs/lens/point.hpp>

/// @file
/// Where lenses show points, by the formulas of COLMAP's and nerfstudio's documents, written out once more.

namespace swiftgs::test {

struct Pixel {
  double x, y;
};

/// A point of the plane before distortion.
inline Pixel on_plane(bool fisheye, const dvec3& p) {
  const double tangent = std::hypot(p.x, p.y) / p.z;
  const double turned = fisheye ? std::atan(tangent) / tangent : 1;
  return {p.x / p.z * turned, p.y / p.z * turned};
}

/// OpenCV's terms p1 and p2.
inline Pixel tangential(double p1, double p2, Pixel at) {
  const double squared = at.x * at.x + at.y * at.y;
  return {2 * p1 * at.x * at.y + p2 * (squared + 2 * at.x * at.x),
          p1 * (squared + 2 * at.y * at.y) + 2 * p2 * at.x * at.y};
}

/// 1 + k[0] r^2 + k[1] r^4 + ...
inline double radial(const std::vector<double>& k, Pixel at) {
  double sum = 1, power = 1;
  for (const double one : k) sum += one * (power *= at.x * at.x + at.y * at.y);
  return sum;
}

/// What the lens of `camera` makes of a point of camera space.
inline Pixel shown_by(const Camera& camera, const dvec3& p) {
  const LensPoint at = point_through(camera.lens, {}, p);
  return {camera.fx * at.u + camera.cx, camera.fy * at.v + camera.cy};
}

inline void check_pixel(const Camera& camera, const dvec3& p, Pixel expected) {
  CAPTURE(p.x);
  CAPTURE(p.y);
  const Pixel shown = shown_by(camera, p);
  CHECK(shown.x == doctest::Approx(expected.x).epsilon(1e-12));
  CHECK(shown.y == doctest::Approx(expected.y).epsilon(1e-12));
}

/// Points in all four quarters of an image.
inline const dvec3 seen_points[] = {{0.3, -0.2, 1}, {-0.5, 0.35, 1.25}, {0.7, 0.9, 2}, {-0.25, -0.6, 0.8}};

}  // namespace swiftgs::test
