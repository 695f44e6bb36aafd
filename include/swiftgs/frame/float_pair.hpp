// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Unevaluated sums of two floats: about 47 bits, for GPUs that have few units for double.

#include <cmath>

#include <swiftgs/frame/math.hpp>

namespace swiftgs {

/// high + low, where high is the sum rounded to float. Errors are bounded with u = 2^-24, as in Joldes,
/// Muller and Popescu 2017, "Tight and rigorous error bounds for basic building blocks of double-word
/// arithmetic", and without terms in u^3.
///
/// Bounds hold while every product is 0 or within 2^-102 and 2^127, and every sum below 2^127. A smaller
/// product is off by up to 2^-147 besides; beyond 2^127 results are NaN or infinite, as are results
/// of these. Hosts keep the bounds unless they compile with -ffast-math.
struct FloatPair {
  float high, low;

  /// Off by u^2 |x| / 2.
  SWIFTGS_HD static FloatPair from(double x) {
    const auto high = float(x);
    return {high, float(x - high)};
  }
  SWIFTGS_HD explicit operator float() const { return high; }
  SWIFTGS_HD explicit operator double() const { return double(high) + double(low); }
  bool operator==(const FloatPair&) const = default;
};

namespace detail {
/// a + b and a b, each rounded by itself: compilers must neither reorder them nor fuse one with the other.
SWIFTGS_HD inline float rounded_sum(float a, float b) {
#if defined(__CUDA_ARCH__)
  return __fadd_rn(a, b);
#else
  return a + b;
#endif
}
SWIFTGS_HD inline float rounded_product(float a, float b) {
#if defined(__CUDA_ARCH__)
  return __fmul_rn(a, b);
#else
  return std::fma(a, b, -0.0f);
#endif
}
}  // namespace detail

/// a + b, exactly, where a is 0 or |a| >= |b|.
SWIFTGS_HD inline FloatPair fast_two_sum(float a, float b) {
  using detail::rounded_sum;
  const float sum = rounded_sum(a, b);
  return {sum, rounded_sum(b, -rounded_sum(sum, -a))};
}

/// a + b, exactly.
SWIFTGS_HD inline FloatPair two_sum(float a, float b) {
  using detail::rounded_sum;
  const float sum = rounded_sum(a, b), of_a = rounded_sum(sum, -b), of_b = rounded_sum(sum, -of_a);
  return {sum, rounded_sum(rounded_sum(a, -of_a), rounded_sum(b, -of_b))};
}

/// a b, exactly.
SWIFTGS_HD inline FloatPair two_product(float a, float b) {
  const float product = detail::rounded_product(a, b);
  return {product, std::fma(a, b, -product)};
}

/// Off by 2 u^2 |a - b| (algorithm 4).
SWIFTGS_HD inline FloatPair operator-(float a, FloatPair b) {
  const FloatPair sum = two_sum(a, -b.high);
  return fast_two_sum(sum.high, detail::rounded_sum(sum.low, -b.low));
}

/// a - b, off by 2 u^2 |a - b|.
SWIFTGS_HD inline FloatPair operator-(FloatPair a, float b) {
  const FloatPair sum = two_sum(a.high, -b);
  return fast_two_sum(sum.high, detail::rounded_sum(sum.low, a.low));
}

namespace detail {
/// a b with a low part of up to 3 u |a b|.
SWIFTGS_HD inline FloatPair unnormalised_product(FloatPair a, FloatPair b) {
  const FloatPair product = two_product(a.high, b.high);
  const float across = std::fma(a.low, b.high, rounded_product(a.high, b.low));
  return {product.high, rounded_sum(product.low, across)};
}
}  // namespace detail

/// Off by 6 u^2 |a b| (algorithm 11).
SWIFTGS_HD inline FloatPair operator*(FloatPair a, FloatPair b) {
  const FloatPair product = detail::unnormalised_product(a, b);
  return fast_two_sum(product.high, product.low);
}

/// a b + c, off by 13 u^2 |a b| + 3 u^2 |c|: 6 and 0 of the product, 3 and 1 of adding the low parts, 4 and 2
/// of adding their sum to the rest of the sum of high parts. Digits that cancel are lost, as in doubles.
SWIFTGS_HD inline FloatPair multiply_add(FloatPair a, FloatPair b, FloatPair c) {
  using detail::rounded_sum;
  const FloatPair product = detail::unnormalised_product(a, b), sum = two_sum(product.high, c.high);
  return fast_two_sum(sum.high, rounded_sum(sum.low, rounded_sum(product.low, c.low)));
}

/// 1 / x, off by 8 u^2 |1 / x| where |x| is within 2^-126 and 2^102: one step of Newton's from the reciprocal
/// of the high part, which is off by 2 u; its square takes 4. Beyond 2^102 the low part is subnormal, and the
/// result off by 2^-149 besides.
SWIFTGS_HD inline FloatPair inverse(FloatPair x) {
#if defined(__CUDA_ARCH__)
  const float near = __frcp_rn(x.high);
#else
  const float near = 1 / x.high;
#endif
  const float off = std::fma(-x.low, near, std::fma(-x.high, near, 1.0f));
  return fast_two_sum(near, detail::rounded_product(near, off));
}

}  // namespace swiftgs
