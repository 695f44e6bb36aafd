// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <swiftgs/edit/transform.hpp>

#include "gltf_document.hpp"

namespace swiftgs::io {

/// A mesh and where a node puts it: p becomes linear p + translation.
struct GltfPlacement {
  std::uint64_t node, mesh;
  dmat3 linear{1.0};
  dvec3 translation{0.0};
};

/// The meshes of the file's scene, in the order of a walk from each root, parents first. Throws `FormatError`
/// where a node is reached twice. `notes` are told of other scenes.
std::vector<GltfPlacement> place_meshes(const GltfDocument& document, std::vector<std::string>& notes);

/// Where Gaussians of the mesh go. Throws `FormatError` if the node, or one above it, stretches, shears or
/// mirrors them.
Similarity movement_of(const GltfDocument& document, const GltfPlacement& placement);

}  // namespace swiftgs::io
