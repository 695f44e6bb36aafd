// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include <swiftgs/pages/paged_scene.hpp>
#include <swiftgs/scene.hpp>

#include "output_file.hpp"

namespace swiftgs::pages {

/// Writes a page file, which gets its name when it is whole. Throws `FileError`.
class PageWriter {
 public:
  explicit PageWriter(const std::filesystem::path& path);

  /// Adds a page and returns its number. The caller sets `first`, children, errors, and the bounds of the
  /// pages below. Harmonics take the fewest bytes that hold them exactly.
  std::uint32_t add(Page page, const Scene& scene, std::span<const std::uint32_t> ids);

  const Page& page(std::uint32_t number) const { return table_[number]; }
  std::size_t pages() const { return table_.size(); }

  /// Writes table and header, and closes the file. `like` has model and origin. Returns the size of the file.
  std::uint64_t finish(std::uint64_t gaussians, std::uint32_t page_size, const Scene& like);

 private:
  void write(std::span<const std::byte> bytes) {
    if (!bytes.empty()) file_.write(bytes.data(), bytes.size());
  }

  io::OutputFile file_;
  std::vector<Page> table_;
};

}  // namespace swiftgs::pages
