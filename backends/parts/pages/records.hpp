// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <utility>
#include <vector>

#include <swiftgs/pages/paged_scene.hpp>
#include <swiftgs/scene.hpp>

#include "disk_file.hpp"

namespace swiftgs::pages {

/// Gaussians in a temporary file without a name, each a row of floats and its number in the source. Throws
/// `FileError`.
class Records {
 public:
  /// Makes its file in `folder`.
  explicit Records(std::filesystem::path folder)
      : folder_(std::move(folder)), file_(DiskFile::unnamed_in(folder_)) {}

  std::size_t size() const { return size_; }
  std::uint64_t checksum() const { return checksum_; }  ///< of what was appended

  /// Adds Gaussians of degree 3 or less, numbered from `first_id` on.
  void append(const Scene& scene, std::uint32_t first_id);

  /// Gaussians [first, first + count), like those of the scene `like`.
  PageContent read(std::size_t first, std::size_t count, const Scene& like);

  /// Moves the `left` Gaussians that are first along the axis on which they spread farthest to one file, and
  /// the others to another. Both keep their order. Takes four bytes a Gaussian.
  std::pair<Records, Records> split(std::size_t left);

 private:
  struct Record {
    vec3 mean, scale;
    Quaternion rotation;
    float opacity;
    vec3 sh0;
    float sh_rest[45];
    std::uint32_t id;
  };
  static_assert(sizeof(Record) == 240);

  /// f(record) of each from number `first` on.
  template <class F>
  void for_each(std::size_t first, std::size_t count, const F& f);
  void add(std::vector<Record>& block, const Record& record);
  void flush(std::vector<Record>& block);

  std::filesystem::path folder_;
  DiskFile file_;
  std::size_t size_ = 0;
  std::uint64_t checksum_ = 0;
};

}  // namespace swiftgs::pages
