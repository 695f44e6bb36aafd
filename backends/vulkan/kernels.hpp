// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

#include <swiftgs/frame/span.hpp>

namespace swiftgs::vulkan {

#define SWIFTGS_VULKAN_KERNELS(f)                                                                    \
  f(fill) f(copy) f(project) f(project_lens) f(compact) f(footprints) f(settle) f(tile_sums) f(emit) \
      f(sort_count) f(sort_move) f(ranges_clear) f(ranges) f(shade) f(attributes) f(attributes_ray)  \
          f(raster) f(raster_long) f(pick) f(load_image) f(store_image) f(copy_rows) f(bound_chunks) \
              f(probe)

/// The shaders, by the names of their files.
enum class Kernel : std::uint32_t {
#define SWIFTGS_VULKAN_NAME(name) name,
  SWIFTGS_VULKAN_KERNELS(SWIFTGS_VULKAN_NAME)
#undef SWIFTGS_VULKAN_NAME
};

std::string_view name_of(Kernel kernel);
/// SPIR-V of `kernel`.
Span<const std::uint32_t> code_of(Kernel kernel);

}  // namespace swiftgs::vulkan
