// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <swiftgs/math.hpp>

namespace swiftgs::detail {

// By their bits: no compiler flag turns these off.
SWIFTGS_HD inline bool is_finite(double value) {
  return (__builtin_bit_cast(std::uint64_t, value) & 0x7ff0000000000000u) != 0x7ff0000000000000u;
}
inline bool is_nan(double value) {
  return (__builtin_bit_cast(std::uint64_t, value) & 0x7fffffffffffffffu) > 0x7ff0000000000000u;
}
SWIFTGS_HD inline bool is_finite(const dvec3& v) {
  return is_finite(v.x) && is_finite(v.y) && is_finite(v.z);
}
SWIFTGS_HD inline bool is_finite(const vec3& v) { return is_finite(dvec3(v)); }

}  // namespace swiftgs::detail
