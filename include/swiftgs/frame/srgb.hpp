// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The sRGB curve of IEC 61966-2-1, continued above 1, and below 0 as an odd function. Hosts and devices
/// compute the same bits: sums of products are all fused by name, and none is left for a compiler to
/// contract.

#include <cmath>
#include <cstdint>

#include <swiftgs/frame/math.hpp>

namespace swiftgs {

namespace detail {
inline constexpr float largest_float = 3.4028234663852886e38f;

/// The first terms of (1 - h)^(-1/n) - 1 over h, and where guesses of x^(-1/n) start.
template <int n>
struct InverseRoot {
  static_assert(n == 10 || n == 12);
  static constexpr float part = float(1.0 / n);
  static constexpr float c1 = part, c2 = float((n + 1.0) / (2.0 * n * n)),
                         c3 = float((n + 1.0) * (2 * n + 1.0) / (6.0 * n * n * n));
  static constexpr int start = int((1 + 1.0 / n) * (0x3f800000 - 0.045 * 0x800000));
};

/// x^(-1/n) of a normal x > 0, about a unit in the last place: a guess from the bits, within 4 %, and two
/// steps of the series.
template <int n>
SWIFTGS_HD inline float inverse_root(float x) {
  using R = InverseRoot<n>;
  float y = __builtin_bit_cast(float, R::start - int(float(__builtin_bit_cast(int, x)) * R::part));
  for (int step = 0; step < 2; ++step) {
    const float y2 = y * y, y4 = y2 * y2;
    const float missing = std::fma(-(x * y4), n == 10 ? y4 * y2 : y4 * y4, 1.0f);  // 1 - x y^n
    y = std::fma(y * missing, std::fma(missing, std::fma(missing, R::c3, R::c2), R::c1), y);
  }
  return y;
}

SWIFTGS_HD inline float with_sign_of(float sign, float magnitude) {
  return __builtin_bit_cast(float, (__builtin_bit_cast(std::uint32_t, sign) & 0x80000000u) |
                                       (__builtin_bit_cast(std::uint32_t, magnitude) & 0x7fffffffu));
}
}  // namespace detail

/// sRGB-encoded value of linear light, within 7 units in the last place. NaN stays NaN.
SWIFTGS_HD inline float to_srgb(float light) {
  const float x = detail::with_sign_of(0, light),
              finite = x < detail::largest_float ? x : detail::largest_float;
  const float root = std::sqrt(x) * detail::inverse_root<12>(finite);  // x^(1/2.4)
  const float curved = std::fma(1.055f, root, -0.055f), straight = 12.92f * x;
  return detail::with_sign_of(light, x <= 0.0031308f ? straight : curved);
}

/// Linear light of an sRGB-encoded value, within 7 units in the last place. NaN stays NaN.
SWIFTGS_HD inline float from_srgb(float encoded) {
  const float x = detail::with_sign_of(0, encoded),
              base = std::fma(x, float(1 / 1.055), float(0.055 / 1.055));
  const float finite = base < detail::largest_float ? base : detail::largest_float;
  const float curved = (base * base) * (std::sqrt(base) * detail::inverse_root<10>(finite));  // base^2.4
  const float straight = x * float(1 / 12.92);
  return detail::with_sign_of(encoded, x <= 0.04045f ? straight : curved);
}

}  // namespace swiftgs
