// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <swiftgs/io/scene_file.hpp>

#include "axis_flip.hpp"
#include "gltf_accessor.hpp"
#include "progress_meter.hpp"

namespace swiftgs::io {

/// What holds Gaussians as SPZ: the latest name, and those of drafts.
inline constexpr const char* gltf_spz_extensions[] = {"KHR_gaussian_splatting_compression_spz_2",
                                                      "KHR_gaussian_splatting_compression_spz",
                                                      "KHR_spz_gaussian_splats_compression"};

/// Where the Gaussians of a primitive are: in accessors, or in an SPZ file of its own.
struct GltfPrimitive {
  GltfAccessor mean{}, rotation{}, scale{}, opacity{}, sh0{};
  std::vector<GltfAccessor> sh_rest{};  ///< for bands 1 and up
  int sh_degree = 0;
  std::optional<std::uint64_t> spz_view{};  ///< then the accessors are not set
  std::span<const std::byte> spz{};

  /// Bytes of the file that each reading of the Gaussians goes through, at least.
  std::uint64_t span() const { return spz_view ? spz.size() : mean.span; }
};

/// `primitive` if it has Gaussians. `mesh` is the mesh that it is of, for errors. `notes` are told of what is
/// stored and not read.
std::optional<GltfPrimitive> find_gaussians(const GltfDocument& document, GltfBuffers& buffers,
                                            const JsonEntry& mesh, const nlohmann::json& primitive,
                                            std::vector<std::string>& notes);

/// Decodes the Gaussians of accessors. Scales were logarithms in drafts of the extension. Sets `logarithmic`
/// if one is below 0, which a scale itself cannot be, and takes logarithms away if it is set.
Scene decode(const GltfPrimitive& primitive, const AxisFlip& flip, const ProgressMeter& progress,
             bool& logarithmic);

}  // namespace swiftgs::io
