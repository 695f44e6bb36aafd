// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What kernels compute with instructions that hosts do not have. Hosts compute the same, rounded better.

#include <cmath>

#include <swiftgs/math.hpp>

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

/// a / b: 2 units in the last place, for b up to 2^126.
SWIFTGS_HD inline float divide_approx(float a, float b) {
#if defined(__CUDA_ARCH__)
  return __fdividef(a, b);
#else
  return a / b;
#endif
}

}  // namespace swiftgs::kernels
