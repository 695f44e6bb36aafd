// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How far the exponent of each representation may be off, proved from the representation's own arithmetic.

#include <algorithm>
#include <cmath>
#include <limits>

#include <swiftgs/conventions.hpp>
#include <swiftgs/reference/conditioning.hpp>

#include "variation.hpp"

namespace swiftgs::reference {

/// A splat's factor applied at a point.
struct FactorAt : Factor {
  double dx, dy, u, v;

  FactorAt(const SplatNumbers& n, double x, double y)
      : Factor(n.factor()), dx(x - n.x), dy(y - n.y), u(l0 * (dx - n.shear * dy)), v(l2 * dy) {}
};

/// Largest error of s at a point that the representation makes, beyond the roundings that any float
/// arithmetic makes.
inline double exponent_error(ExponentRepresentation representation, const SplatNumbers& numbers, double x,
                             double y) {
  if (representation == ExponentRepresentation::factor) return 0;
  const FactorAt at(numbers, x, y);
  const double l1 = std::abs(at.l1);
  if (representation == ExponentRepresentation::float_split) {
    const double wide = std::abs(at.u) + 16 * (at.l0 + l1), high = std::abs(at.v) + 16 * at.l2;
    return std::ldexp(wide * wide + high * high, -18);
  }
  // Each of the four stored terms is rounded to 11 bits, or to 2^-25 where it is subnormal; the mixed term is
  // a product of two.
  const double dx = std::abs(at.dx), dy = std::abs(at.dy);
  const double a = at.l0 * at.l0 * dx * dx, c = (l1 * l1 + at.l2 * at.l2) * dy * dy;
  const double b = 2 * at.l0 * l1 * dx, largest_half = 65504;
  if (!(std::max({a, b, c, dy}) <= largest_half)) return std::numeric_limits<double>::infinity();
  return std::ldexp(1.01 * (a + c + 2 * b * dy), -11) + std::ldexp(2 + b + dy, -24);
}

/// Whether a rasterizer evaluates a splat at pixel (x, y) at all: rasterizers skip rows of 16 pixels in which
/// the splat keeps none. Only a representation that may err widely far from the splat needs to know.
inline bool may_be_visited(ExponentRepresentation representation, const SplatNumbers& numbers, int x, int y,
                           const Conventions& k) {
  if (representation != ExponentRepresentation::half_split) return true;
  const double first = 16 * std::floor(x / 16.0) + 0.5, at_y = y + 0.5;
  const FactorAt left(numbers, first, at_y), right(numbers, first + 15, at_y);
  const double nearest = left.u > 0 ? left.u : right.u < 0 ? right.u : 0;
  const double s = nearest * nearest + left.v * left.v;
  const double cutoff = numbers.log2_opacity - std::log2(double(k.alpha_min));
  return s <= 1.001 * std::max(cutoff, 0.0) + 0.001;
}

}  // namespace swiftgs::reference
