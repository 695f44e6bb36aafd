// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include <swiftgs/pages/paged_scene.hpp>
#include <swiftgs/scene.hpp>

namespace swiftgs::pages {

using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

/// Opens a file as `std::fopen` does. Throws `FileError` with its name.
File open_file(const std::filesystem::path& path, const char* mode);
/// Throws `FileError` unless all `bytes` could be written.
void write_bytes(std::FILE* file, std::span<const std::byte> bytes, const std::filesystem::path& path);
/// Throws `FileError` unless all `bytes` could be read.
void read_bytes(std::FILE* file, std::span<std::byte> bytes, const std::filesystem::path& path);

/// Writes a page file front to back, its header last.
class PageWriter {
 public:
  explicit PageWriter(const std::filesystem::path& path);

  /// Adds a page and returns its number. The caller sets `first`, children, errors, and the bounds of the
  /// pages below. Harmonics take the fewest bytes that hold them exactly.
  std::uint32_t add(Page page, const Scene& scene, std::span<const std::uint32_t> ids);

  const Page& page(std::uint32_t number) const { return table_[number]; }
  std::size_t pages() const { return table_.size(); }

  /// Writes table and header. `like` has model and origin. Returns the size of the file.
  std::uint64_t finish(std::uint64_t gaussians, std::uint32_t page_size, const Scene& like);

 private:
  void write(std::span<const std::byte> bytes);

  std::filesystem::path path_;
  File file_;
  std::uint64_t size_ = 0;
  std::vector<Page> table_;
};

}  // namespace swiftgs::pages
