// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/pages/paged_scene.hpp>
#include <swiftgs/scene.hpp>

#include "disk_file.hpp"
#include "nodes.hpp"

namespace swiftgs::pages {

/// Writes a page file, which gets its name when it is whole. Until then it is OUT.unfinished, and
/// OUT.unfinished.steps has what else a build needs to resume: a key, and of every page its row of the table,
/// how far its nodes are from their Gaussians, and a checksum of key and both. Both files stay where a build
/// ends early, unless they have no page. The next one with the same key begins with the pages that are whole.
/// Throws `FileError`.
class PageWriter {
 public:
  /// Opens and locks both files. Throws `InvalidArgument` while another build writes them, or if no build
  /// made them.
  explicit PageWriter(const std::filesystem::path& out);

  /// Finds the pages of an earlier build with the same `key`, which identifies all that pages depend on. The
  /// model and the origin are those of `like`. If `progress` throws, the files stay as they are. Throws
  /// `InvalidArgument` for a model whose text the header cannot hold.
  void begin(std::uint64_t key, std::uint64_t gaussians, const Scene& like, const Progress& progress);

  std::size_t found() const { return found_; }     ///< pages that an earlier build had written
  bool began_anew() const { return began_anew_; }  ///< Leftovers had another key and were discarded
  /// The two files, and the folder where they lie.
  const std::filesystem::path& unfinished() const { return file_.path(); }
  const std::filesystem::path& steps() const { return steps_.path(); }
  std::filesystem::path folder() const { return place_.has_parent_path() ? place_.parent_path() : "."; }
  /// Whether files would remain if the build ended now.
  bool leaves_files() const { return !steps_.is_temporary(); }

  /// Whether the next `pages`, those of one subtree, were found. They then count as added.
  bool take_found(std::size_t pages);
  /// Nodes of a page, and Gaussians of a leaf.
  Nodes nodes(std::uint32_t page) const;

  /// Adds a page and returns its number. The caller sets `first`, children, errors, and the bounds of the
  /// pages below. Harmonics take the fewest bytes that hold them exactly.
  std::uint32_t add(Page page, const Nodes& nodes, std::span<const std::uint32_t> ids);

  const Page& page(std::uint32_t number) const { return state_.pages[number]; }
  std::uint32_t pages() const { return std::uint32_t(added_); }  ///< that were added

  /// Writes table and header, and puts the file in its place. Returns its size.
  std::uint64_t finish(std::uint32_t page_size);

 private:
  /// Takes over pages from the files until one is not whole.
  void find(const Progress& progress);
  /// Of a step. Only builds of the same key accept it.
  std::uint64_t checksum_of_step(const Page& page, std::span<const std::byte> spread) const;
  void set_temporary(bool temporary);

  std::filesystem::path place_;
  DiskFile steps_, file_;  ///< in this order: who has locked the steps has both files
  std::uint64_t key_ = 0;
  int sh_degree_ = 0;
  PagedScene::State state_;            ///< with the rows of all pages
  std::vector<std::uint64_t> spread_;  ///< of each page, where its spread lies in `steps_`
  std::uint64_t end_ = 0;              ///< of the contents
  std::uint64_t steps_end_ = 0;
  std::size_t found_ = 0, added_ = 0;
  bool began_anew_ = false;
};

}  // namespace swiftgs::pages
