// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <swiftgs/affine.hpp>

#include "gltf_document.hpp"

namespace swiftgs::io {

inline constexpr const char* gltf_visibility_extension = "KHR_node_visibility";

/// A mesh and where a node puts it. A node is hidden by a matrix of zeros: its own scale, or its visibility.
struct GltfPlacement {
  std::uint64_t node, mesh;
  Affine movement{};

  bool is_hidden() const { return movement.linear == dmat3(0.0); }
};

/// The meshes of the file's scene, in the order of a walk from each root, parents first. Throws `FormatError`
/// where a node is reached twice. `notes` are told of other scenes.
std::vector<GltfPlacement> place_meshes(const GltfDocument& document, std::vector<std::string>& notes);

/// Throws `FormatError` that names the node if it, with those above it, mirrors or flattens: the extension
/// leaves undefined how Gaussians look then.
void expect_drawable(const GltfDocument& document, const GltfPlacement& placement);

}  // namespace swiftgs::io
