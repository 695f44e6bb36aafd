// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/pages/page_pool.hpp>

#include "options.hpp"
#include "read/placed_input.hpp"

namespace CLI {
class App;
}

namespace swiftgs::cli {

/// How pages are drawn.
struct PageOptions {
  double pixels = 1;        ///< as `CutGoal::pixels`
  double blend = 0;         ///< as `CutGoal::blend`
  double megabytes = 2000;  ///< that pages take of the backend's memory
  double estimate = 0;      ///< megabytes of the host that measure how far frames are from the scene

  CutGoal goal() const { return {.pixels = pixels, .blend = blend}; }
  /// Throws `std::invalid_argument` unless `megabytes` are above 0, `estimate` is 0 or more, and both are
  /// below 1e9.
  PagePoolOptions pool() const;
};

/// Adds `--pixels`, `--blend`, `--pool`, `--estimate` and `--paged`.
void add_page_options(CLI::App& command, PageOptions& options, SceneOptions& scene);

/// Draws plain and paged scenes together. Chooses the pages that cameras need, and has a renderer show them.
/// The renderer must outlive it.
class PageFrames {
 public:
  /// Uploads the scenes without pages. Throws as `PagePool`, and `std::invalid_argument` for these beside
  /// `PagePoolOptions::estimate`, which knows nothing of them.
  PageFrames(AnyRenderer& renderer, const DrawnScenes& drawn, HarmonicsKept kept,
             const PagePoolOptions& pool);

  /// Places the scenes anew. Throws as `PagePool::place` and `validate`, and changes nothing then.
  void place(const std::vector<Placement>& placements);

  /// Chooses the pages of a frame of all `cameras`, and has the renderer show them.
  const Cut& show(Span<const Camera> cameras, const RenderSettings& settings, const CutGoal& goal);
  /// The same with all pages there. Throws `std::runtime_error` where one cannot be read, and what uploads
  /// throw; the renderer shows nothing then.
  const Cut& show_complete(Span<const Camera> cameras, const RenderSettings& settings, const CutGoal& goal);

  const Cut& cut() const { return cut_; }
  const PagePool<AnyRenderer>& pool() const { return *pool_; }
  /// The placement that a scene of the cut has.
  std::size_t placement_of(std::size_t scene) const { return paged_[scene]; }

 private:
  void choose(Span<const Camera> cameras, const RenderSettings& settings, const CutGoal& goal);
  void show();

  AnyRenderer& renderer_;
  std::vector<std::optional<PagedScene>> files_;
  std::vector<std::optional<UploadedScene>> uploaded_;  ///< of files without pages
  std::optional<PagePool<AnyRenderer>> pool_;
  std::vector<std::size_t> paged_;   ///< placements with pages
  std::vector<PlacedScene> others_;  ///< without pages
  std::vector<swiftgs::View> views_;
  Cut cut_;
};

}  // namespace swiftgs::cli
