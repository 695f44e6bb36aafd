// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Forms of the exponent. For hosts too, which test it.
///
/// Those of a lane's pixels have two functions. `prepare` finds the terms of a splat as a part of a tile sees
/// it, its mean relative to the part's first pixel; `evaluate` finds log2(alpha) of the lane's pixels from
/// the place of the first within the part. Terms that are cleared show nothing.

#include <cmath>

#include <vector_functions.h>

#include <swiftgs/raster/raster.hpp>
#include <swiftgs/splats.hpp>

#include "arithmetic.hpp"

namespace swiftgs::kernels {

/// Pixels of a lane are of one column, so what depends on the column is computed once.
inline constexpr unsigned pixels_of_lane = 2;
inline constexpr float rows_between = 4;

/// `FloatCholesky` in registers: u = l0 x + l1 y + c and v = l2 y + d at pixel (x, y) of the part, s = u^2 +
/// v^2. From one pixel of a lane to the next, u and v grow by what depends on the splat alone.
struct CholeskyForm {
  struct Terms {
    float4 factor;   ///< l0, l1, l2, log2(opacity)
    float2 offsets;  ///< c, d
  };

  SWIFTGS_HD static void prepare(const SplatShape& s, vec2 mean, float log2_alpha_min, Terms& terms) {
    terms.factor = make_float4(s.l0, s.l1, s.l2, s.reach + log2_alpha_min);
    terms.offsets = make_float2(-fmaf(s.l0, mean.x, s.l1 * mean.y), -s.l2 * mean.y);
  }
  SWIFTGS_HD static void clear(Terms& terms) { terms = {make_float4(0, 0, 0, -INFINITY), make_float2(0, 0)}; }

  SWIFTGS_HD static void evaluate(const Terms& terms, float x, float y, float (&exponents)[pixels_of_lane]) {
    const float4 f = terms.factor;
    const float2 offsets = terms.offsets;
    const float u = fmaf(f.x, x, fmaf(f.y, y, offsets.x)), v = fmaf(f.z, y, offsets.y);
    const float lower_u = fmaf(f.y, rows_between, u);
    const float lower_v = fmaf(f.z, rows_between, v);
    exponents[0] = fmaf(-u, u, fmaf(-v, v, f.w));
    exponents[1] = fmaf(-lower_u, lower_u, fmaf(-lower_v, lower_v, f.w));
  }
};

/// `FloatSplit` in registers, measured from the part's first pixel: s = a x^2 + b x y + c y^2 + d x + e y +
/// g. What depends on the column alone is computed once for both pixels of a lane.
struct SplitForm {
  struct Terms {
    float4 squares;  ///< a, b, c, log2(opacity) - g
    float4 linear;   ///< d, e, log2(opacity), unused
  };

  SWIFTGS_HD static void prepare(const SplatShape& s, vec2 mean, float log2_alpha_min, Terms& terms) {
    const float log2_opacity = s.reach + log2_alpha_min;
    const float u = -fmaf(s.l0, mean.x, s.l1 * mean.y), v = -s.l2 * mean.y;
    const float a = s.l0 * s.l0, c = fmaf(s.l1, s.l1, s.l2 * s.l2), g = fmaf(u, u, v * v);
    terms.squares = make_float4(a, 2 * s.l0 * s.l1, c, log2_opacity - g);
    terms.linear = make_float4(2 * s.l0 * u, 2 * fmaf(s.l1, u, s.l2 * v), log2_opacity, 0);
    // Far below any splat that meets a pixel, sums of squares leave the range of float.
    const float largest = 1e30f;
    if (!(a < largest && c < largest && g < largest)) clear(terms);
  }
  SWIFTGS_HD static void clear(Terms& terms) {
    terms = {make_float4(0, 0, 0, -INFINITY), make_float4(0, 0, 0, 0)};
  }

  SWIFTGS_HD static void evaluate(const Terms& terms, float x, float y, float (&exponents)[pixels_of_lane]) {
    const float4 f = terms.squares, linear = terms.linear;
    const float mixed = fmaf(f.y, x, linear.y), rest = fmaf(-x, fmaf(f.x, x, linear.x), f.w);
    for (int p = 0; p < int(pixels_of_lane); ++p) {
      const float at = y + float(p) * rows_between;
      // Rounding may make s negative where it is nearly zero.
      exponents[p] = fminf(fmaf(-at, fmaf(f.z, at, mixed), rest), linear.z);
    }
  }
};

/// `PerPixel`: the whole exponent from the factor, as it is stored.
struct FactorForm {
  /// l0, l1, l2 and the opacity.
  SWIFTGS_HD static float4 prepare(const SplatShape& s) { return make_float4(s.l0, s.l1, s.l2, s.opacity); }

  /// Alpha of a pixel that lies so far from the mean, 0 where it skips the splat.
  SWIFTGS_HD static float alpha(const float4& factor, float dx, float dy, const BlendRules& rules) {
    const float u = fmaf(factor.x, dx, factor.y * dy), v = factor.z * dy;
    const float alpha = factor.w * exp2_approx(-fmaf(u, u, v * v));
    return alpha >= rules.alpha_min ? fminf(alpha, rules.alpha_max) : 0.0f;
  }
};

}  // namespace swiftgs::kernels
