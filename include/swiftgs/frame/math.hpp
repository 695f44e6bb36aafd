// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Vectors for host and device code, tests for finite numbers, and markers of functions.

#include <cmath>
#include <cstdint>

#if defined(__CUDACC__)
#define SWIFTGS_HD __host__ __device__
#else
#define SWIFTGS_HD
#endif
#define SWIFTGS_NOINLINE __attribute__((noinline))

#if defined(__CUDACC__)
// GLM marks its functions for the device if it knows the version of CUDA, for which it would include
// <cuda.h>. The runtime, which nvcc includes by itself, has the same number. GLM reads it once, at its first
// inclusion. nvcc warns of each defaulted function that is marked.
#pragma push_macro("CUDA_VERSION")
#undef CUDA_VERSION
#define CUDA_VERSION CUDART_VERSION
#pragma nv_diagnostic push
#pragma nv_diag_suppress 20012
#endif
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#if defined(__CUDACC__)
#pragma nv_diagnostic pop
#pragma pop_macro("CUDA_VERSION")
#endif

namespace swiftgs {

#if defined(GLM_SWIZZLE_OPERATOR) && GLM_CONFIG_SWIZZLE == GLM_SWIZZLE_OPERATOR
static_assert(GLM_CONFIG_SWIZZLE != GLM_SWIZZLE_OPERATOR,
              "GLM_FORCE_SWIZZLE and GLM_FORCE_INTRINSICS change how functions take a vec3, expected the "
              "vec3 that the libraries are compiled with: drop one of the two");
#endif

// Packed, whatever GLM_FORCE_DEFAULT_ALIGNED_GENTYPES and the like make of a program's own vectors: kernels
// read arrays of these as plain floats, and compiled libraries take them. GLM converts between the two.
using dmat3 = glm::mat<3, 3, double, glm::packed_highp>;
using dmat4 = glm::mat<4, 4, double, glm::packed_highp>;
using dvec3 = glm::vec<3, double, glm::packed_highp>;
using vec2 = glm::vec<2, float, glm::packed_highp>;
using vec3 = glm::vec<3, float, glm::packed_highp>;
using vec4 = glm::vec<4, float, glm::packed_highp>;

template <class Real>
using Vector2 = glm::vec<2, Real, glm::packed_highp>;
/// `vec3` or `dvec3`.
template <class Real>
using Vector3 = glm::vec<3, Real, glm::packed_highp>;

/// Hamilton quaternion, scalar part first. It is not a vec4, so that its order is never in doubt.
struct Quaternion {
  float w = 1, x = 0, y = 0, z = 0;
  bool operator==(const Quaternion&) const = default;
};

/// a . b, each product fused with the sum of those after it.
template <class Real>
SWIFTGS_HD Real dot(const Vector3<Real>& a, const Vector3<Real>& b) {
  return std::fma(a.x, b.x, std::fma(a.y, b.y, a.z * b.z));
}

/// a b - c d, the first product not rounded.
template <class Real>
SWIFTGS_HD Real difference_of_products(Real a, Real b, Real c, Real d) {
  return std::fma(a, b, -(c * d));
}
template <class Real>
SWIFTGS_HD Vector3<Real> cross(const Vector3<Real>& a, const Vector3<Real>& b) {
  return {difference_of_products(a.y, b.z, a.z, b.y), difference_of_products(a.z, b.x, a.x, b.z),
          difference_of_products(a.x, b.y, a.y, b.x)};
}

/// a b + c, rounded once.
SWIFTGS_HD inline double multiply_add(double a, double b, double c) { return std::fma(a, b, c); }

/// 1 / sqrt(x) for x > 0, 2 units in the last place.
SWIFTGS_HD inline float inverse_sqrt(float x) {
#if defined(__CUDA_ARCH__)
  // Newton's step from the special function unit's result: six instructions in place of twenty.
  const float near = rsqrtf(x);
  return std::fma(near, std::fma(-0.5f * x * near, near, 0.5f), near);
#else
  return 1 / std::sqrt(x);
#endif
}

/// The same in double. Of 0, of subnormal and of infinite numbers a device makes no number.
SWIFTGS_HD inline double inverse_sqrt(double x) {
#if defined(__CUDA_ARCH__)
  double y;
  asm("rsqrt.approx.ftz.f64 %0, %1;" : "=d"(y) : "d"(x));  // 20 bits; a step doubles them
  y = std::fma(y, std::fma(-0.5 * x * y, y, 0.5), y);
  return std::fma(y, std::fma(-0.5 * x * y, y, 0.5), y);
#else
  return 1 / std::sqrt(x);
#endif
}

/// sqrt(x) and 1 / x, on a device 2 units in the last place and without subnormal numbers: there an exact one
/// takes four times the instructions. For bounds, whose slack covers more.
SWIFTGS_HD inline float near_sqrt(float x) {
#if defined(__CUDA_ARCH__)
  float y;
  asm("sqrt.approx.ftz.f32 %0, %1;" : "=f"(y) : "f"(x));
  return y;
#else
  return std::sqrt(x);
#endif
}
SWIFTGS_HD inline float near_inverse(float x) {
#if defined(__CUDA_ARCH__)
  float y;
  asm("rcp.approx.ftz.f32 %0, %1;" : "=f"(y) : "f"(x));
  return y;
#else
  return 1 / x;
#endif
}

/// 1 / x, 2 units in the last place. Of 0, of subnormal and of infinite numbers a device makes no number.
SWIFTGS_HD inline double inverse(double x) {
#if defined(__CUDA_ARCH__)
  double y;
  asm("rcp.approx.ftz.f64 %0, %1;" : "=d"(y) : "d"(x));
  y = std::fma(y, std::fma(-x, y, 1.0), y);
  return std::fma(y, std::fma(-x, y, 1.0), y);
#else
  return 1 / x;
#endif
}

/// log2(e): exp(v) = exp2(log2_e * v).
inline constexpr double log2_e = 1.4426950408889634;

}  // namespace swiftgs

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
