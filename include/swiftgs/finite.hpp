// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <swiftgs/math.hpp>

namespace swiftgs::detail {

// The bits are those that lie in memory: a compiler that is told that all numbers are finite takes what it
// works out itself, and arguments, to be so.
inline bool is_finite(const float& value) {
  const float seen = const_cast<const volatile float&>(value);
  return (__builtin_bit_cast(std::uint32_t, seen) & 0x7f800000u) != 0x7f800000u;
}
inline bool is_finite(const double& value) {
  const double seen = const_cast<const volatile double&>(value);
  return (__builtin_bit_cast(std::uint64_t, seen) & 0x7ff0000000000000u) != 0x7ff0000000000000u;
}
inline bool is_finite(const vec3& v) { return is_finite(v.x) && is_finite(v.y) && is_finite(v.z); }
inline bool is_finite(const dvec3& v) { return is_finite(v.x) && is_finite(v.y) && is_finite(v.z); }
inline bool is_nan(const double& value) {
  const double seen = const_cast<const volatile double&>(value);
  return (__builtin_bit_cast(std::uint64_t, seen) & 0x7fffffffffffffffu) > 0x7ff0000000000000u;
}

}  // namespace swiftgs::detail
