// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The shaders' arithmetic as C++: what the language lacks, and the files themselves.

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <glm/vec4.hpp>

#include <swiftgs/frame/math.hpp>

namespace swiftgs::test::glsl {

using uint = std::uint32_t;
using uvec4 = glm::uvec4;
using std::abs, std::ceil, std::floor, std::fma, std::log2, std::max, std::min, std::sqrt;

inline uint floatBitsToUint(float x) { return __builtin_bit_cast(uint, x); }
inline float uintBitsToFloat(uint x) { return __builtin_bit_cast(float, x); }
inline float roundEven(float x) { return std::nearbyint(x); }
/// Off by two units in the last place, as Vulkan allows.
inline float inversesqrt(float x) { return 1 / std::sqrt(x) * (1 + 0x1p-22f); }

inline bool FUSES = false;
#define FUNCTION inline
#define PRECISE
#define INOUT(T) T&
// clang-format off
#include "pairs.glsl"
#include "project.glsl"
#include "bounds.glsl"
#include "lens.glsl"
#include "lens_box.glsl"
#include "chunks.glsl"
// clang-format on
#undef FUNCTION
#undef PRECISE
#undef INOUT

}  // namespace swiftgs::test::glsl
