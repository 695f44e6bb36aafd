// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <limits>

#include <swiftgs/frame/splats.hpp>

namespace swiftgs::test {

/// Of float: the distance from 1 to the next number.
inline constexpr double epsilon = std::numeric_limits<float>::epsilon();
/// Pixels along the side of a warp block of a tile.
inline constexpr int part = 8;

/// s = u^2 + v^2 of a splat at a point in double, and the largest error of float arithmetic that sums up
/// u and v from terms that may cancel.
struct ExactSquare {
  double u, v, s, error;

  ExactSquare(const SplatShape& shape, double x, double y) {
    const double dx = x - shape.exact_mean().x, dy = y - shape.exact_mean().y;
    u = double(shape.l0) * dx + double(shape.l1) * dy, v = double(shape.l2) * dy;
    s = u * u + v * v;
    const double wide = std::abs(dx) + part, high = std::abs(dy) + part;
    const double terms = std::abs(double(shape.l0)) * wide + std::abs(double(shape.l1)) * high +
                         std::abs(double(shape.l2)) * high;
    error = 4 * epsilon * (std::sqrt(s) + 4 * epsilon * terms) * terms + epsilon * (2 * s + 16);
  }
  /// The split form sums up s itself: the bound that `FloatSplit` states, beside that of u and v.
  double split_error(const SplatShape& shape) const {
    const double wide = std::abs(u) + 16 * (double(shape.l0) + std::abs(double(shape.l1)));
    const double high = std::abs(v) + 16 * double(shape.l2);
    return error + std::ldexp(wide * wide + high * high, -18);
  }
};

}  // namespace swiftgs::test
