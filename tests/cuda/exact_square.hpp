// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <limits>

#include <swiftgs/splats.hpp>

namespace swiftgs::test {

/// Of float: the distance from 1 to the next number.
inline constexpr double epsilon = std::numeric_limits<float>::epsilon();
/// Pixels along the side of a part of a tile.
inline constexpr int part = 8;

/// s = u^2 + v^2 of a splat at a point in double, and the largest error of float arithmetic that sums up
/// u and v from terms that may cancel.
struct ExactSquare {
  double s, error;

  ExactSquare(const SplatShape& shape, double x, double y) {
    const double dx = x - double(shape.mean.x), dy = y - double(shape.mean.y);
    const double u = double(shape.l0) * dx + double(shape.l1) * dy, v = double(shape.l2) * dy;
    s = u * u + v * v;
    const double wide = std::abs(dx) + part, high = std::abs(dy) + part;
    const double terms = std::abs(double(shape.l0)) * wide + std::abs(double(shape.l1)) * high +
                         std::abs(double(shape.l2)) * high;
    error = 4 * epsilon * (std::sqrt(s) + 4 * epsilon * terms) * terms + epsilon * (2 * s + 16);
  }
  /// The split form sums up s itself.
  double split_error(const SplatShape& shape, double x, double y) const {
    const double dx = std::abs(x - double(shape.mean.x)) + part;
    const double dy = std::abs(y - double(shape.mean.y)) + part;
    const double u = std::abs(double(shape.l0)) * dx + std::abs(double(shape.l1)) * dy;
    const double v = std::abs(double(shape.l2)) * dy;
    return 4 * epsilon * (u * u + v * v) + 16 * epsilon;
  }
};

}  // namespace swiftgs::test
