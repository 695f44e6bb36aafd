// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <swiftgs/frame/math.hpp>

namespace swiftgs {

/// IEEE 754 half: stored only; arithmetic happens in float.
struct Half {
  std::uint16_t bits = 0;
};

/// Rounds to nearest even; beyond 65,504 becomes infinite.
SWIFTGS_HD inline Half to_half(float value) {
  const std::uint32_t f = __builtin_bit_cast(std::uint32_t, value);
  const std::uint32_t sign = (f >> 16) & 0x8000u, magnitude = f & 0x7fffffffu;
  if (magnitude > 0x7f800000u) return {std::uint16_t(sign | 0x7e00u)};   // NaN
  if (magnitude >= 0x477ff000u) return {std::uint16_t(sign | 0x7c00u)};  // rounds beyond the largest half
  if (magnitude < 0x38800000u) {
    // Subnormal: adding 0.5 lets the float unit round at the half's last place, 2^-24.
    const float shifted = __builtin_bit_cast(float, magnitude) + 0.5f;
    return {std::uint16_t(sign | (__builtin_bit_cast(std::uint32_t, shifted) - 0x3f000000u))};
  }
  const std::uint32_t rebased = magnitude - (112u << 23);
  return {std::uint16_t(sign | ((rebased + 0xfffu + ((rebased >> 13) & 1u)) >> 13))};
}

/// Exact.
SWIFTGS_HD inline float to_float(Half half) {
  const std::uint32_t sign = (half.bits & 0x8000u) << 16, magnitude = half.bits & 0x7fffu;
  if (magnitude >= 0x7c00u)
    return __builtin_bit_cast(float, sign | 0x7f800000u | ((magnitude & 0x3ffu) << 13));
  if (magnitude < 0x400u) {
    const float value = float(magnitude) * 5.9604644775390625e-8f;  // 2^-24
    return sign ? -value : value;
  }
  return __builtin_bit_cast(float, sign | ((magnitude << 13) + (112u << 23)));
}

}  // namespace swiftgs
