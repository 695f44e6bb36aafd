// SPDX-License-Identifier: Apache-2.0
#include "kernels.hpp"

#include <cstddef>
#include <iterator>
#include <string>
#include <string_view>

#include <swiftgs/error.hpp>
#include <swiftgs/version.hpp>

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

/// The entry point of a module of SPIR-V; empty if it has none for compute, or is not whole: the last
/// instruction ends the last function.
std::string_view entry_of(Span<const std::uint32_t> module) {
  constexpr std::uint32_t magic = 0x07230203, compute = 5;
  constexpr std::uint32_t op_entry_point = 15, op_function_end = 56;
  constexpr std::size_t header = 5, name_at = 3;
  std::string_view entry;
  std::uint32_t op = 0;
  if (module.size < header || module[0] != magic) return {};
  for (std::size_t at = header, words = 0; at < module.size; at += words) {
    op = module[at] & 0xffff, words = module[at] >> 16;
    if (words == 0 || words > module.size - at) return {};
    if (op != op_entry_point || words <= name_at || module[at + 1] != compute) continue;
    const char* const name = reinterpret_cast<const char*>(module.data + at + name_at);
    entry = {name, (words - name_at) * sizeof(std::uint32_t)};
    entry = entry.substr(0, entry.find('\0'));
  }
  return op == op_function_end ? entry : std::string_view();
}
}  // namespace

std::string_view name_of(Kernel kernel) {
#define SWIFTGS_VULKAN_NAME(name) #name,
  static constexpr std::string_view names[] = {SWIFTGS_VULKAN_KERNELS(SWIFTGS_VULKAN_NAME)};
#undef SWIFTGS_VULKAN_NAME
  return names[std::size_t(kernel)];
}

Code Shader::code() const {
  if (!own_) return {code_of(kernel_), "main"};
  const std::string expected = std::string(name_of(kernel_)) + '-' + std::string(version);
  const std::string_view found = entry_of(*own_);
  if (found != expected)
    detail::refuse("vulkan: the shaders of ", policy_, " have ",
                   found.empty() ? std::string("no SPIR-V of a compute shader")
                                 : "the entry point " + std::string(found),
                   " for the kernel ", name_of(kernel_), ", expected ", expected,
                   " as swiftgs_add_shaders of this version compiles it");
  return {*own_, expected};
}

}  // namespace swiftgs::vulkan
