// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <swiftgs/math.hpp>

namespace swiftgs::detail {

/// The bits of a number, read from memory. With -ffast-math a compiler assumes that arguments and results are
/// finite, but it assumes nothing of memory. Kernels are never compiled with it.
template <class Bits, class T>
SWIFTGS_HD Bits bits_in_memory(const T& value) {
#ifdef __CUDA_ARCH__
  return __builtin_bit_cast(Bits, value);
#else
  const T seen = const_cast<const volatile T&>(value);
  return __builtin_bit_cast(Bits, seen);
#endif
}

SWIFTGS_HD inline bool is_finite(const float& value) {
  return (bits_in_memory<std::uint32_t>(value) & 0x7f800000u) != 0x7f800000u;
}
SWIFTGS_HD inline bool is_finite(const double& value) {
  return (bits_in_memory<std::uint64_t>(value) & 0x7ff0000000000000u) != 0x7ff0000000000000u;
}
SWIFTGS_HD inline bool is_finite(const vec3& v) { return is_finite(v.x) && is_finite(v.y) && is_finite(v.z); }
SWIFTGS_HD inline bool is_finite(const dvec3& v) {
  return is_finite(v.x) && is_finite(v.y) && is_finite(v.z);
}
inline bool is_nan(const double& value) {
  return (bits_in_memory<std::uint64_t>(value) & 0x7fffffffffffffffu) > 0x7ff0000000000000u;
}

}  // namespace swiftgs::detail
