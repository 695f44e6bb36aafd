// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Paged scenes: a scene's Gaussians in pages, and coarser pages that stand for them. docs/page_format.md
/// describes every byte of a page file, docs/pages.md which files of others are read. Part of swiftgs::pages.

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <swiftgs/conventions.hpp>
#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/scene.hpp>

namespace swiftgs {

/// A row of the table of pages, as a page file has it. A leaf holds Gaussians of the source. A parent holds
/// nodes, each of which stands for Gaussians below its two children. Of other files, only bounds, bytes,
/// first, count, degree and errors mean something, and whether `left` is none.
struct Page {
  static constexpr std::uint32_t none = 0xffffffff;
  static constexpr std::size_t error_count = 8;

  ChunkBounds bounds{};            ///< of its nodes and of all pages below it, relative to the origin
  std::uint64_t offset = 0;        ///< of its content in the file, a multiple of 64
  std::uint64_t bytes = 0;         ///< of its content
  std::uint64_t checksum = 0;      ///< of its content
  std::uint64_t first = 0;         ///< Gaussians of the leaves before its own
  std::uint32_t count = 0;         ///< Gaussians or nodes
  std::uint32_t rows = 0;          ///< of harmonics
  std::uint32_t left = none;       ///< child with the leaves that come first; none of a leaf
  std::uint32_t right = none;      ///< the other child, of a page file
  float harmonic_scale = 1;        ///< as `HarmonicRows::scale`
  std::uint8_t harmonic_format{};  ///< a `HarmonicFormat`
  std::uint8_t sh_degree = 0;      ///< of the rows, 0 to 3
  std::uint8_t has_labels = 0;     ///< 1: rows are a palette
  std::uint8_t has_ids = 0;        ///< 1: numbers of the Gaussians in the source follow; else `first` and up
  float finest = 1;                ///< pixel's size of the first of `errors` @units{scene}
  float unused = 0;                ///< 0
  /// How far the nodes are from their Gaussians, seen with pixels of the size `finest` 4^k: nine tenths of
  /// what shows are at most so far off. 0 of a leaf. @units{scene}
  std::array<float, error_count> errors{};

  bool is_leaf() const { return left == none; }
  /// The error seen with pixels of `size`, above 0. @units{scene}
  double error_at(double size) const {
    const double at = 0.5 * std::log2(size / double(finest));
    if (!(at > 0)) return errors.front();
    if (at >= double(error_count - 1)) return errors.back();
    const auto below = std::size_t(at);
    return std::lerp(double(errors[below]), double(errors[below + 1]), at - double(below));
  }
};
static_assert(sizeof(Page) == 128);

/// What a page holds.
struct PageContent {
  Scene scene;
  std::vector<std::uint32_t> ids;  ///< of the Gaussians in the source, if they are not consecutive
};

/// Fills `to` with the bytes of a page file from `offset` on, or throws. Several threads call it at once.
using PageSource = std::function<void(std::uint64_t offset, std::span<std::byte> to)>;

/// An open page file, or another scene with levels of detail. Copies are one file.
class SWIFTGS_API PagedScene {
 public:
  const std::string& name() const { return state_->name; }
  const char* format() const { return state_->format; }  ///< such as "page file"
  std::uint64_t gaussians() const { return state_->gaussians; }
  std::uint32_t page_size() const { return state_->page_size; }  ///< most Gaussians or nodes of a page
  int sh_degree() const { return state_->sh_degree; }
  const RenderingModel& model() const { return state_->model; }
  const dvec3& origin() const { return state_->origin; }  ///< as `Scene::origin`

  /// All pages. Parents come behind their children, so the last is the root.
  Span<const Page> pages() const { return {state_->pages.data(), state_->pages.size()}; }
  std::uint32_t root() const { return std::uint32_t(state_->pages.size() - 1); }
  /// Pages that together show what `page` stands for; none of a leaf.
  Span<const std::uint32_t> children(std::uint32_t page) const {
    const std::uint32_t begin = state_->first_child[page], end = state_->first_child[page + 1];
    return {state_->children.data() + begin, end - begin};
  }
  /// Whether both are one file that was opened once.
  bool operator==(const PagedScene&) const = default;

  /// Reads a page. Throws `FormatError` if its content was changed after writing, and passes on exceptions of
  /// its source. Safe from several threads at once.
  PageContent read(std::uint32_t page) const;

  /// Opens a file of `size` bytes that `source` reads; `name` stands for it in errors. Throws as
  /// `open_pages`.
  PagedScene(PageSource source, std::uint64_t size, std::string name);

  /// What a paged scene consists of, for files of other formats.
  struct State {
    std::function<PageContent(std::uint32_t page)> read;
    std::string name;
    const char* format = "page file";
    std::uint64_t gaussians = 0;
    std::uint32_t page_size = 0;
    int sh_degree = 0;
    RenderingModel model{};
    dvec3 origin{0.0};
    std::vector<Page> pages;
    std::vector<std::uint32_t> children;     ///< of all pages, one behind the other
    std::vector<std::uint32_t> first_child;  ///< of each page in `children`; and the end
  };
  /// Trusts `state`.
  explicit PagedScene(State state) : state_(std::make_shared<const State>(std::move(state))) {}

 private:
  std::shared_ptr<const State> state_;
};

/// Whether `path` is a page file, or a tileset of 3D Tiles: under any name if `root` begins in its first 64
/// KiB.
SWIFTGS_API bool is_page_file(const std::filesystem::path& path);

/// Opens a page file and maps it into memory; or the `lod-meta.json` of a streamed SOG, or a tileset of 3D
/// Tiles. These name other files, which are read with their pages; one is read at once, for the rendering
/// model. Checks header and table, but reads no page. Files must not change while they are open. Throws
/// `FormatError` that says what was expected where, and `FileError`.
SWIFTGS_API PagedScene open_pages(const std::filesystem::path& path);

/// All leaves as one scene, in their order: what a frame of all leaves draws. Throws as `PagedScene::read`.
SWIFTGS_API Scene read_leaves(const PagedScene& pages);

}  // namespace swiftgs
