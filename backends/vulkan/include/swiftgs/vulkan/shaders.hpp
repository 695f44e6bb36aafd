// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Shaders of a program's own policies. `swiftgs_add_shaders` of CMake compiles them from a file of GLSL.

#include <cstddef>
#include <cstdint>

#include <swiftgs/frame/span.hpp>

namespace swiftgs::vulkan {

/// SPIR-V of the kernels that count and emit the tiles within bounds.
struct BoundsShaders {
  Span<const std::uint32_t> compact, footprints, emit;
};

/// SPIR-V of the kernels that blend by a rasterizer: `raster_long` blends blocks with long lists.
struct RasterShaders {
  Span<const std::uint32_t> raster, raster_long;
};

/// The shaders of a policy of your own. Specialise it by a pointer to `BoundsShaders` or `RasterShaders`,
/// which stay as they are and where they are while there are devices that drew with them:
///
///     template <>
///     inline constexpr const auto* swiftgs::vulkan::shaders<OneSigma> = &one_sigma_shaders;
template <class Policy>
inline constexpr std::nullptr_t shaders = nullptr;

}  // namespace swiftgs::vulkan
