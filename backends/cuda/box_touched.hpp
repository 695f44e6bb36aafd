// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include <swiftgs/splats.hpp>

#include "arithmetic.hpp"

namespace swiftgs::kernels {

/// What a coordinate of a mean in an image lacks as a float, at most. @units{pixels}
inline constexpr float most_lacking = 0x1p-8f;

/// Whether the ellipse s <= cutoff meets the box of pixel centres that begins at `first` and is `side` - 1
/// wide and high. Reads means in float, and takes a box that much wider.
///
/// A splat that does not pass is not drawn. Conservative bounds include every tile that passes, so frames do
/// not depend on bounds. s is convex: its least value lies at the mean, or on the edge nearest to it at the
/// mean's height.
SWIFTGS_HD inline bool box_touched(const SplatShape& s, vec2 first, float side) {
  const float last = side - 1 + 2 * most_lacking;
  const float left = first.x - most_lacking - s.mean.x, right = left + last;
  const float top = first.y - most_lacking - s.mean.y, bottom = top + last;
  const float nearest_y = fminf(fmaxf(0, top), bottom);
  const float u_left = fmaf(s.l0, left, s.l1 * nearest_y), u_right = fmaf(s.l0, right, s.l1 * nearest_y);
  const float edge = u_left > 0 ? left : right;
  const float along = divide_approx(-s.l0 * s.l1 * edge, fmaf(s.l1, s.l1, s.l2 * s.l2));
  const bool across = u_left <= 0 && u_right >= 0;
  const float y = across ? nearest_y : fminf(fmaxf(along, top), bottom);
  const float u = across ? 0.0f : fmaf(s.l0, edge, s.l1 * y), v = s.l2 * y;
  // Pixels round differently from this, so they decide so close to the edge.
  return fmaf(u, u, v * v) <= s.cutoff * 1.0001f;
}

}  // namespace swiftgs::kernels
