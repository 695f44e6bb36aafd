// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Vectors for host and device code, and the marker of functions that run on both.

#if defined(__CUDACC__)
#define SWIFTGS_HD __host__ __device__
#else
#define SWIFTGS_HD
#endif

#if defined(__CUDACC__)
// GLM marks its functions for the device only when it has seen <cuda.h>, and then draws a warning for each
// defaulted one.
#include <cuda.h>
#define GLM_FORCE_CUDA
#pragma nv_diagnostic push
#pragma nv_diag_suppress 20012
#endif
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#if defined(__CUDACC__)
#pragma nv_diagnostic pop
#endif

namespace swiftgs {

using glm::dmat3;
using glm::dvec3;
using glm::vec2;
using glm::vec3;
using glm::vec4;

// Kernels of every backend read arrays of these as plain floats.
static_assert(sizeof(vec3) == 3 * sizeof(float) && alignof(vec3) == alignof(float));

/// Hamilton quaternion, scalar part first. It is not a vec4, so that its order is never in doubt.
struct Quaternion {
  float w = 1, x = 0, y = 0, z = 0;
  bool operator==(const Quaternion&) const = default;
};

/// log2(e): exp(v) = exp2(log2_e * v).
inline constexpr double log2_e = 1.4426950408889634;

}  // namespace swiftgs
