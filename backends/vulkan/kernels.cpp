// SPDX-License-Identifier: Apache-2.0
#include "kernels.hpp"

#include <cstddef>
#include <iterator>

namespace swiftgs::vulkan {
namespace {
// clang-format off
#include "attributes.comp.hpp"
#include "attributes_ray.comp.hpp"
#include "bound_chunks.comp.hpp"
#include "copy.comp.hpp"
#include "copy_rows.comp.hpp"
#include "compact.comp.hpp"
#include "emit.comp.hpp"
#include "fill.comp.hpp"
#include "footprints.comp.hpp"
#include "load_image.comp.hpp"
#include "pick.comp.hpp"
#include "probe.comp.hpp"
#include "project.comp.hpp"
#include "project_lens.comp.hpp"
#include "ranges.comp.hpp"
#include "ranges_clear.comp.hpp"
#include "raster.comp.hpp"
#include "raster_long.comp.hpp"
#include "settle.comp.hpp"
#include "shade.comp.hpp"
#include "sort_count.comp.hpp"
#include "sort_move.comp.hpp"
#include "store_image.comp.hpp"
#include "tile_sums.comp.hpp"
// clang-format on
}  // namespace

std::string_view name_of(Kernel kernel) {
#define SWIFTGS_VULKAN_NAME(name) #name,
  static constexpr std::string_view names[] = {SWIFTGS_VULKAN_KERNELS(SWIFTGS_VULKAN_NAME)};
#undef SWIFTGS_VULKAN_NAME
  return names[std::size_t(kernel)];
}

Span<const std::uint32_t> code_of(Kernel kernel) {
  switch (kernel) {
#define SWIFTGS_VULKAN_CODE(name) \
  case Kernel::name:              \
    return {name##_code, std::size(name##_code)};
    SWIFTGS_VULKAN_KERNELS(SWIFTGS_VULKAN_CODE)
#undef SWIFTGS_VULKAN_CODE
  }
  return {};
}

}  // namespace swiftgs::vulkan
