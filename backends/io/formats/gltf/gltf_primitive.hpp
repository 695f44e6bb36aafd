// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <swiftgs/scene.hpp>

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
  std::uint64_t count = 0;
  int sh_degree = 0;  ///< of what is kept
  RenderingModel model{};
  std::optional<std::uint64_t> spz_view{};  ///< then the accessors are not set
  std::span<const std::byte> spz{};

  /// The SPZ file, as errors name it.
  Source spz_source(const Source& document) const {
    return {spz, document.name + ": buffer view " + std::to_string(*spz_view)};
  }
};

/// Some Gaussians of a primitive, and where they go in a scene of the same or a higher degree.
struct GltfRange {
  std::size_t first, count, to;
};

/// `primitive` if it has Gaussians. `mesh` is the mesh that it is of, for errors. `notes` are told of what is
/// stored and not read.
std::optional<GltfPrimitive> find_gaussians(const GltfDocument& document, GltfBuffers& buffers,
                                            const JsonEntry& mesh, const nlohmann::json& primitive,
                                            std::vector<std::string>& notes);

/// Whether the scales are logarithms, as drafts of the extension had them: one is below 0, which a scale
/// itself cannot be.
bool has_scale_below_zero(const GltfPrimitive& primitive, const ProgressMeter& progress);

/// Decodes Gaussians of accessors, whose scales may be `logarithmic`.
void decode(const GltfPrimitive& primitive, const AxisFlip& flip, bool logarithmic, const GltfRange& range,
            const ProgressMeter& progress, Scene& scene);

}  // namespace swiftgs::io
