// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
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

/// SPIR-V, and the name of its entry point.
struct Code {
  Span<const std::uint32_t> words;
  std::string entry;
};

/// A kernel by the library's code, or by that of a policy of the program's own.
class Shader {
 public:
  Shader(Kernel kernel) : kernel_(kernel) {}
  /// `policy` is a `BoundsKind` or a `RasterKind`, and `code` what its own shaders have for `kernel`.
  template <class Policy, class Shaders>
  Shader(Kernel kernel, const Policy& policy, Span<const std::uint32_t> Shaders::*code)
      : kernel_(kernel), policy_(policy.name) {
    if (policy.own) own_ = &(policy.own->*code);
  }

  Kernel kernel() const { return kernel_; }
  /// Tells own code apart; null for the library's.
  const void* own() const { return own_; }
  /// Throws `InvalidArgument` for own code that is damaged, or that `swiftgs_add_shaders` of this version did
  /// not compile for this kernel.
  Code code() const;

 private:
  Kernel kernel_;
  std::string_view policy_{};
  const Span<const std::uint32_t>* own_ = nullptr;
};

}  // namespace swiftgs::vulkan
