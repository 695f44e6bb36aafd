// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <swiftgs/edit/affine.hpp>

#include "bytes.hpp"
#include "json_entry.hpp"

namespace swiftgs::io {

/// The JSON of a glTF file, text or binary (GLB), and where its parts lie in the file.
///
/// Data URIs hold most of a text file. They are cut out before the rest is parsed, so that a tree of JSON
/// values is not as large as the scene.
class GltfDocument {
 public:
  /// A string that is a data URI, and where it is in the file. One with escapes is not cut out; its place is
  /// that of the object around it.
  struct DataUri {
    std::string_view text;
    std::uint64_t offset;
  };

  /// `source` must outlive the document, and the document must not move.
  explicit GltfDocument(const Source& source);
  GltfDocument(const GltfDocument&) = delete;
  GltfDocument& operator=(const GltfDocument&) = delete;

  const Source& source() const { return source_; }
  bool binary() const { return binary_; }
  JsonEntry root() const { return {source_, root_, offset_of(text().find('{')), "a glTF"}; }

  /// The chunk of a GLB that is its first buffer; none in a text file.
  std::optional<std::span<const std::byte>> chunk() const { return chunk_; }

  /// Elements of an array of the root, such as "nodes"; 0 if the file has none.
  std::size_t size(const char* array) const;

  /// Element `index` of an array of the root. `user` is what refers to it, for the error where it is absent.
  JsonEntry item(const char* array, std::uint64_t index, const JsonEntry& user) const;

  /// The member `uri` of `entry` if it is a data URI.
  std::optional<DataUri> data_uri(const JsonEntry& entry) const;

 private:
  /// A string that is left out of `text`, before its closing quote.
  struct Cut {
    std::uint64_t position;  ///< in the text, of what stands for it
    std::uint64_t length;    ///< of what stands for it
    DataUri uri;
  };

  std::string_view text() const { return cuts_.empty() ? whole_ : std::string_view(shortened_); }
  std::uint64_t offset_of(std::uint64_t position) const;
  void split_binary();
  void cut_data_uris();
  void parse();

  const Source& source_;
  bool binary_ = false;
  std::string_view whole_{};
  std::optional<std::span<const std::byte>> chunk_{};
  std::string shortened_{};
  std::vector<Cut> cuts_{};
  nlohmann::json root_{};
  std::map<std::string, std::vector<std::uint64_t>, std::less<>> offsets_{};  ///< of elements of arrays
};

/// A string of the file as JSON writes it, cut where it is long: fit for a message of one line.
std::string shown(const nlohmann::json& value);

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
