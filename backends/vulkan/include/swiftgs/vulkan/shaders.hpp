// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Shaders of a program's own policies. `swiftgs_add_shaders` of CMake compiles them from a file of GLSL.

#include <cstddef>
#include <cstdint>

#include <swiftgs/bounds/all.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/raster/all.hpp>

namespace swiftgs::vulkan {

/// SPIR-V of the kernels that count and emit the tiles within bounds.
struct BoundsShaders {
  Span<const std::uint32_t> compact, footprints, emit;
};

/// SPIR-V of the kernels that blend by a rasterizer: `raster_long` blends blocks with long lists.
struct RasterShaders {
  Span<const std::uint32_t> raster, raster_long;
};

/// The library's policies have shaders, which a program cannot replace.
template <class Policy>
concept PolicyOfProgram = !AllBounds::contains<Policy> && !AllRasters::contains<Policy>;

/// The shaders of bounds or a rasterizer of your own. Specialise it by a pointer to `BoundsShaders` or
/// `RasterShaders`, which do not change or move while a device that drew with them lives:
///
///     template <>
///     inline constexpr const auto* swiftgs::vulkan::shaders<OneSigma> = &one_sigma_shaders;
template <PolicyOfProgram Policy>
inline constexpr std::nullptr_t shaders = nullptr;

}  // namespace swiftgs::vulkan
