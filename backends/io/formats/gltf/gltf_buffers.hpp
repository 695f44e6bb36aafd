// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <span>

#include "gltf_document.hpp"
#include "mapped_file.hpp"
#include "progress_meter.hpp"

namespace swiftgs::io {

/// The bytes that a glTF file's accessors lie in. A buffer is opened or decoded when it is first asked for.
/// Each function throws `FormatError` for an index or a range that does not exist; `user` is what asks.
class GltfBuffers {
 public:
  struct View {
    std::span<const std::byte> bytes;
    std::uint64_t stride;  ///< 0: elements lie back to back
  };

  /// `progress` is told of the part of the file that was decoded.
  GltfBuffers(const GltfDocument& document, const ProgressMeter& progress)
      : document_(document), progress_(progress) {}

  View view(std::uint64_t index, const JsonEntry& user);

  /// Bytes of all buffers that were asked for; those of a file that several name count once.
  std::uint64_t size() const { return size_; }

  /// Bytes of other files that were opened.
  std::uint64_t size_beside() const { return size_beside_; }

  bool has_decoded() const { return !decoded_.empty(); }

 private:
  std::span<const std::byte> buffer(std::uint64_t index, const JsonEntry& user);
  std::span<const std::byte> open(std::uint64_t index, const JsonEntry& entry);
  std::span<const std::byte> decode(const GltfDocument::DataUri& uri);
  std::span<const std::byte> counted(std::span<const std::byte> bytes) {
    size_ += bytes.size();
    return bytes;
  }

  const GltfDocument& document_;
  const ProgressMeter progress_;
  std::map<std::uint64_t, std::span<const std::byte>> buffers_{};
  std::map<std::filesystem::path, std::unique_ptr<MappedFile>> files_{};
  std::set<FileIdentity> opened_{};
  std::vector<std::unique_ptr<std::byte[]>> decoded_{};
  std::uint64_t size_ = 0, size_beside_ = 0;
  std::uint64_t characters_ = 0;  ///< that were decoded
};

/// The path that a relative URI names, percent-decoded; empty unless it stays in the folder that it is
/// relative to.
std::filesystem::path path_of_uri(std::string_view uri);

}  // namespace swiftgs::io
