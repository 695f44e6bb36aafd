// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Arithmetic of kernels: device instructions, the exponent of `FloatCholesky`, and the test of a warp block.
/// Hosts compute the same, rounded better, and test it.
///
/// `prepare` finds a splat's terms from the vector from its mean to the warp block's first pixel, and from h
/// = log2(opacity / alpha_max). `evaluate` finds log2(alpha / alpha_max) at the lane's pixels from the place
/// of the first within the warp block. `evaluate_one` finds the same bits at one pixel, `right` columns to
/// the right of that place. Terms are a quadruple and a `Rest`, apart because shared memory is read by words
/// of 16 bytes. Cleared terms show nothing.

#include <cmath>

#include <vector_functions.h>

#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/raster.hpp>
#include <swiftgs/frame/splats.hpp>

namespace swiftgs::kernels {

/// exp2 of the device's special function unit: 2 units in the last place.
SWIFTGS_HD inline float exp2_approx(float x) {
#if defined(__CUDA_ARCH__)
  float result;
  asm("ex2.approx.ftz.f32 %0, %1;" : "=f"(result) : "f"(x));
  return result;
#else
  return std::exp2(x);
#endif
}

/// x cut to 0 and 1; 0 for NaN. Devices do it in the instruction that computes x.
SWIFTGS_HD inline float saturate(float x) {
#if defined(__CUDA_ARCH__)
  return __saturatef(x);
#else
  return x > 0 ? std::fmin(x, 1.0f) : 0.0f;
#endif
}

/// a * b, rounded by itself: compilers do not join it with an addition.
SWIFTGS_HD inline float multiply_rounded(float a, float b) {
#if defined(__CUDA_ARCH__)
  return __fmul_rn(a, b);
#else
  return a * b;
#endif
}

/// a / b: 2 units in the last place, for b from 2^-126 to 2^126.
SWIFTGS_HD inline float divide_approx(float a, float b) {
#if defined(__CUDA_ARCH__)
  float result;
  asm("div.approx.ftz.f32 %0, %1, %2;" : "=f"(result) : "f"(a), "f"(b));
  return result;
#else
  return a / b;
#endif
}

/// Pixels of a lane are of one row, so what depends on the row is computed once.
inline constexpr unsigned pixels_of_lane = 2;
inline constexpr unsigned columns_between = 4;

/// log2(opacity / alpha_max) of a splat.
SWIFTGS_HD inline float relative_log2_opacity(const SplatShape& s, const BlendRules& rules) {
  return log2_opacity(s, rules.log2_relative_min, rules.alpha_max);
}

/// `FloatCholesky` in registers: u = l0 x + l1 y + c and v = l2 y + d at pixel (x, y) of the warp block, s =
/// u^2 + v^2. Pixels of a lane share v, and from one to the next u grows by what depends on the splat alone.
struct CholeskyExponent {
  // Measured on an H200 when chosen: rasterizing garden takes 134 us with nine, 136 with ten and 149 with
  // eleven.
  static constexpr unsigned blocks = 9;  ///< of a multiprocessor at once: 56 registers a thread
  using Rest = float2;                   ///< c, d; the quadruple is l0, l1, l2, h

  SWIFTGS_HD static void prepare(const SplatShape& s, vec2 from_mean, float h, float4& terms, Rest& rest) {
    terms = make_float4(s.l0, s.l1, s.l2, h);
    rest = make_float2(fmaf(s.l0, from_mean.x, s.l1 * from_mean.y), s.l2 * from_mean.y);
  }
  SWIFTGS_HD static void clear(float4& terms, Rest& rest) {
    terms = make_float4(0, 0, 0, -INFINITY), rest = make_float2(0, 0);
  }

  SWIFTGS_HD static void evaluate(const float4& terms, const Rest& rest, float x, float y,
                                  float (&exponents)[pixels_of_lane]) {
    const float v = fmaf(terms.z, y, rest.y), row = fmaf(-v, v, terms.w);
    const float first = fmaf(terms.x, x, fmaf(terms.y, y, rest.x));
    for (unsigned p = 0; p < pixels_of_lane; ++p) {
      // Compilers keep a product with 0, so the first pixel has none.
      const float u = p == 0 ? first : fmaf(terms.x, float(p * columns_between), first);
      exponents[p] = fmaf(-u, u, row);
    }
  }
  SWIFTGS_HD static float evaluate_one(const float4& terms, const Rest& rest, float x, float y, float right) {
    const float v = fmaf(terms.z, y, rest.y), row = fmaf(-v, v, terms.w);
    const float u = fmaf(terms.x, right, fmaf(terms.x, x, fmaf(terms.y, y, rest.x)));
    return fmaf(-u, u, row);
  }
};

/// Whether the ellipse s <= cutoff meets the box of pixel centres that begins at `first` and is `side` - 1
/// wide and high.
///
/// A splat that does not pass is not drawn. Conservative bounds include every tile that passes, so frames do
/// not depend on bounds. s is convex: its least value lies at the mean, or on the edge nearest to it at the
/// mean's height.
SWIFTGS_HD inline bool box_touched(const SplatShape& s, vec2 first, float side) {
  const vec2 from_mean = s.from_mean(first);
  const float left = from_mean.x, right = left + (side - 1), top = from_mean.y, bottom = top + (side - 1);
  const float nearest_y = fminf(fmaxf(0, top), bottom);
  const float u_left = fmaf(s.l0, left, s.l1 * nearest_y), u_right = fmaf(s.l0, right, s.l1 * nearest_y);
  const float on_edge = s.l0 * (u_left > 0 ? left : right);
  const float along = divide_approx(-s.l1 * on_edge, fmaf(s.l1, s.l1, s.l2 * s.l2));
  const bool across = u_left <= 0 && u_right >= 0;
  const float y = across ? nearest_y : fminf(fmaxf(along, top), bottom);
  const float u = across ? 0.0f : fmaf(s.l1, y, on_edge), v = s.l2 * y;
  // Pixels round differently from this, so they decide so close to the edge.
  return fmaf(u, u, v * v) <= s.cutoff * 1.0001f;
}

}  // namespace swiftgs::kernels
