// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Forms of the exponent. For hosts too, which test it.
///
/// Those of a lane's pixels have two functions. `prepare` finds the terms of a splat as a part of a tile sees
/// it, its mean relative to the part's first pixel; `evaluate` finds log2(alpha) of the lane's pixels from
/// the place of the first within the part, and which of them may keep the splat.

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
  SWIFTGS_HD static void prepare(const SplatShape& s, vec2 mean, float log2_alpha_min, float4& terms,
                                 float2& offsets) {
    terms = make_float4(s.l0, s.l1, s.l2, s.reach + log2_alpha_min);
    offsets = make_float2(-fmaf(s.l0, mean.x, s.l1 * mean.y), -s.l2 * mean.y);
  }

  SWIFTGS_HD static void evaluate(const float4& terms, const float2& offsets, float x, float y,
                                  float (&exponents)[pixels_of_lane], bool (&valid)[pixels_of_lane]) {
    const float u = fmaf(terms.x, x, fmaf(terms.y, y, offsets.x)), v = fmaf(terms.z, y, offsets.y);
    const float lower_u = fmaf(terms.y, rows_between, u);
    const float lower_v = fmaf(terms.z, rows_between, v);
    exponents[0] = fmaf(-u, u, fmaf(-v, v, terms.w));
    exponents[1] = fmaf(-lower_u, lower_u, fmaf(-lower_v, lower_v, terms.w));
    valid[0] = valid[1] = true;  // a sum of squares is never negative
  }
};

/// `FloatSplit` in registers: a dx^2 and b dx once for both pixels of a lane, c dy^2 for each.
struct SplitForm {
  SWIFTGS_HD static void prepare(const SplatShape& s, vec2 mean, float log2_alpha_min, float4& terms,
                                 float2& offsets) {
    terms =
        make_float4(s.l0 * s.l0, 2 * s.l0 * s.l1, fmaf(s.l1, s.l1, s.l2 * s.l2), s.reach + log2_alpha_min);
    offsets = make_float2(mean.x, mean.y);
  }

  SWIFTGS_HD static void evaluate(const float4& terms, const float2& offsets, float x, float y,
                                  float (&exponents)[pixels_of_lane], bool (&valid)[pixels_of_lane]) {
    const float dx = x - offsets.x, mixed = terms.y * dx;
    const float rest = fmaf(-terms.x * dx, dx, terms.w);
    for (int p = 0; p < int(pixels_of_lane); ++p) {
      const float dy = y + float(p) * rows_between - offsets.y;
      exponents[p] = fmaf(-dy, fmaf(terms.z, dy, mixed), rest);
      valid[p] = exponents[p] <= terms.w;  // rounding may make s negative where it is nearly zero
    }
  }
};

/// gsplat's: sigma = (a dx^2 + c dy^2) / 2 + b dx dy. A conic is a, b, c and the opacity.
struct ConicForm {
  SWIFTGS_HD static float4 prepare(const SplatShape& s) {
    const float two_ln_2 = 1.38629436111989061883f;
    return make_float4(two_ln_2 * s.l0 * s.l0, two_ln_2 * s.l0 * s.l1, two_ln_2 * (s.l1 * s.l1 + s.l2 * s.l2),
                       s.opacity);
  }

  /// Alpha of a pixel that lies so far from the mean, 0 where it skips the splat.
  SWIFTGS_HD static float alpha(const float4& conic, float dx, float dy, const BlendRules& rules) {
    const float sigma = 0.5f * (conic.x * dx * dx + conic.z * dy * dy) + conic.y * dx * dy;
    const float alpha = conic.w * exp2_approx(float(-log2_e) * sigma);
    const bool kept = sigma >= 0 && alpha >= rules.alpha_min;
    return kept ? fminf(alpha, rules.alpha_max) : 0.0f;
  }
};

}  // namespace swiftgs::kernels
