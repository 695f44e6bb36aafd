// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <swiftgs/math.hpp>

namespace swiftgs::detail {

// By their bits and where they lie: a compiler that is told that numbers are finite believes it of arguments too.
SWIFTGS_HD inline bool is_finite(const float& value) {
  return (__builtin_bit_cast(std::uint32_t, value) & 0x7f800000u) != 0x7f800000u;
}
SWIFTGS_HD inline bool is_finite(const double& value) {
  return (__builtin_bit_cast(std::uint64_t, value) & 0x7ff0000000000000u) != 0x7ff0000000000000u;
}
SWIFTGS_HD inline bool is_finite(const vec3& v) { return is_finite(v.x) && is_finite(v.y) && is_finite(v.z); }
SWIFTGS_HD inline bool is_finite(const dvec3& v) {
  return is_finite(v.x) && is_finite(v.y) && is_finite(v.z);
}
inline bool is_nan(const double& value) {
  return (__builtin_bit_cast(std::uint64_t, value) & 0x7fffffffffffffffu) > 0x7ff0000000000000u;
}

}  // namespace swiftgs::detail
