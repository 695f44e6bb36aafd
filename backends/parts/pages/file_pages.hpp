// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include <swiftgs/edit/affine.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/pages/paged_scene.hpp>

/// @file
/// Paged scenes of files that others wrote: a page is Gaussians of one scene file or more.

namespace swiftgs::pages {

/// Gaussians of a scene file, moved.
struct FilePart {
  static constexpr std::size_t all = std::size_t(-1);

  std::string file;
  std::size_t first = 0, count = 0;  ///< in the file; `first` of `all`: all of them
  Affine world_from_file{};
};

/// A box around means, and Gaussians that lie in it.
struct Bounds {
  dvec3 low{1e30}, high{-1e30};

  /// What is no number makes the box endless.
  void add(const dvec3& point);
  void add(const Bounds& other) { add(other.low), add(other.high); }
  double longest_side() const;
};

/// Collects pages, children before their parent.
class FilePages {
 public:
  /// `path` is the file that names the others.
  explicit FilePages(const std::filesystem::path& path) : path_(path) {}

  [[noreturn]] void fail(const std::string& expected) const;

  /// Adds a page with a constant error. Throws `FormatError` for bounds that are not finite, and for too
  /// many levels, files or Gaussians. @units{scene}
  std::uint32_t add(std::vector<FilePart> parts, const Bounds& bounds, double error, int sh_degree,
                    std::vector<std::uint32_t> children);
  const std::vector<FilePart>& parts(std::uint32_t page) const { return parts_[page]; }
  const Bounds& bounds(std::uint32_t page) const { return bounds_[page]; }
  std::size_t size() const { return parts_.size(); }

  /// The scene whose root is the last page. Reads a file of it, which tells the rendering model. Throws
  /// `FormatError` for no page, and what `read_scene` throws.
  PagedScene finish(const char* format) &&;

 private:
  std::filesystem::path path_;
  PagedScene::State state_;
  std::vector<std::vector<FilePart>> parts_;
  std::vector<Bounds> bounds_;
  std::vector<int> levels_;       ///< of each page, itself included
  std::size_t parts_in_all_ = 0;  ///< of all pages
};

/// The JSON of a file. Throws as `parse_json`, and `FileError`.
nlohmann::json json_of(const std::filesystem::path& path);

/// Calls `open`; throws `FormatError` if a JSON value has another kind than `open` expects.
template <class Open>
auto with_kinds(const std::filesystem::path& path, const Open& open) {
  try {
    return open();
  } catch (const nlohmann::json::exception&) {
    throw FormatError(path.string(), 0, "members of the kinds that the format has");
  }
}

/// Open files that name others. They read JSON, of each tile's content too, and the Gaussians of one file.
PagedScene open_streamed_sog(const std::filesystem::path& path);
PagedScene open_tiles(const std::filesystem::path& path);

}  // namespace swiftgs::pages
