// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The exponents of kernels of `FloatSplit`, with the members of `CholeskyExponent`, and of `PerPixel`.

#include <cmath>

#include <vector_functions.h>

#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/splats.hpp>
#include <swiftgs/frame/views.hpp>

#include "exponents.hpp"

namespace swiftgs::kernels {

/// `FloatSplit` in registers, measured from the warp block's first pixel: s = a x^2 + b x y + c y^2 + d x + e
/// y + g. What depends on the row alone is computed once for both pixels of a lane.
struct SplitExponent {
  static constexpr unsigned blocks = 8;
  using Rest = float4;  ///< d, e, h, unused; the quadruple is a, b, c, h - g

  SWIFTGS_HD static void prepare(const SplatShape& s, vec2 from_mean, float h, float4& terms, Rest& rest) {
    const float u = fmaf(s.l0, from_mean.x, s.l1 * from_mean.y), v = s.l2 * from_mean.y;
    const float a = s.l0 * s.l0, c = fmaf(s.l1, s.l1, s.l2 * s.l2), g = fmaf(u, u, v * v);
    terms = make_float4(a, 2 * s.l0 * s.l1, c, h - g);
    rest = make_float4(2 * s.l0 * u, 2 * fmaf(s.l1, u, s.l2 * v), h, 0);
    // Larger squares could overflow, and `fminf` would turn a difference of infinities into full opacity.
    const float largest = 1e30f;
    if (!(a < largest && c < largest && g < largest)) clear(terms, rest);
  }
  SWIFTGS_HD static void clear(float4& terms, Rest& rest) {
    terms = make_float4(0, 0, 0, -INFINITY), rest = make_float4(0, 0, 0, 0);
  }

  SWIFTGS_HD static void evaluate(const float4& terms, const Rest& rest, float x, float y,
                                  float (&exponents)[pixels_of_lane]) {
    for (unsigned p = 0; p < pixels_of_lane; ++p)
      exponents[p] = evaluate_one(terms, rest, x, y, float(p * columns_between));
  }
  SWIFTGS_HD static float evaluate_one(const float4& terms, const Rest& rest, float x, float y, float right) {
    const float mixed = fmaf(terms.y, y, rest.x), row = fmaf(-y, fmaf(terms.z, y, rest.y), terms.w);
    const float at = x + right;
    // Rounding may make s negative where it is nearly zero.
    return fminf(fmaf(-at, fmaf(terms.x, at, mixed), row), rest.z);
  }
};

/// `PerPixel`: the whole exponent from the factor, as it is stored.
struct FactorExponent {
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
