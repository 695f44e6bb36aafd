// SPDX-License-Identifier: Apache-2.0
#include "draw/page_frames.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include <CLI/CLI.hpp>

#include <swiftgs/error.hpp>

namespace swiftgs::cli {

PagePoolOptions PageOptions::pool() const {
  if (!(megabytes > 0 && megabytes < 1e9))
    throw std::invalid_argument("--pool: expected megabytes above 0 and below 1e9");
  if (!(estimate >= 0 && estimate < 1e9))
    throw std::invalid_argument("--estimate: expected megabytes of 0 or more and below 1e9");
  return {.bytes = std::size_t(1e6 * megabytes), .estimate = std::size_t(1e6 * estimate)};
}

void add_page_options(CLI::App& command, PageOptions& options, SceneOptions& scene) {
  command
      .add_option("--pixels", options.pixels,
                  "Of pages: largest error of a page that is drawn; 0 draws all Gaussians")
      ->capture_default_str();
  command
      .add_option("--blend", options.blend,
                  "Of pages: part of the error over which levels fade into each other, such as 0.5; 0: none")
      ->capture_default_str();
  command
      .add_option("--pool", options.megabytes,
                  "Of pages: most memory that they take where they are drawn, in MB")
      ->capture_default_str();
  command
      .add_option("--estimate", options.estimate,
                  "Of pages alone: measure how far frames are from the scene, by a processor and so many MB, "
                  "such as 512; 0: not at all")
      ->capture_default_str();
  command.add_flag("--paged", scene.paged, "Draw all levels of a streamed SOG as pages");
}

PageFrames::PageFrames(AnyRenderer& renderer, const DrawnScenes& drawn, HarmonicsKept kept,
                       const PagePoolOptions& pool)
    : renderer_(renderer), files_(drawn.pages) {
  std::vector<PlacedPages> pages;
  for (std::size_t i = 0; i < files_.size(); ++i) {
    uploaded_.emplace_back();
    if (files_[i])
      pages.push_back({*files_[i]});
    else if (pool.estimate != 0)
      throw std::invalid_argument("--estimate: a scene without pages, expected page files alone");
    else
      uploaded_[i].emplace(renderer.upload(Scene(*drawn.gaussians[i]), kept));
  }
  pool_.emplace(renderer, std::move(pages), pool);
  place(drawn.placements);
}

void PageFrames::place(const std::vector<Placement>& placements) {
  std::vector<PlacedPages> pages;
  std::vector<PlacedScene> others;
  std::vector<std::size_t> paged;
  for (std::size_t i = 0; i < placements.size(); ++i) {
    const Placement& p = placements[i];
    if (files_[p.scene]) {
      if (p.count == 0) continue;  // hidden
      pages.push_back({*files_[p.scene], p.world_from_scene, p.opacity, p.clip, p.tint});
      paged.push_back(i);
      continue;
    }
    const SceneView whole = uploaded_[p.scene]->view();
    const SceneView part = range_of(whole, p.first, std::min(p.count, whole.size() - p.first));
    validate(others.emplace_back(PlacedScene{part, p.world_from_scene, p.opacity, p.clip, p.tint}));
  }
  pool_->place(std::move(pages));
  others_ = std::move(others), paged_ = std::move(paged);
}

void PageFrames::choose(Span<const Camera> cameras, const RenderSettings& settings, const CutGoal& goal) {
  make_views(cameras, settings, views_);
  cut_ = pool_->cut({views_.data(), views_.size()}, goal);
}

void PageFrames::show() {
  std::vector<PlacedScene> all = cut_.scenes();
  all.insert(all.end(), others_.begin(), others_.end());
  renderer_.show({all.data(), all.size()});
}

const Cut& PageFrames::show(Span<const Camera> cameras, const RenderSettings& settings, const CutGoal& goal) {
  choose(cameras, settings, goal);
  show();
  return cut_;
}

const Cut& PageFrames::show_complete(Span<const Camera> cameras, const RenderSettings& settings,
                                     const CutGoal& goal) {
  renderer_.show({});  // not the pages that waiting gives back
  choose(cameras, settings, goal);
  pool_->wait(cut_);
  if (!cut_.failed().empty()) throw std::runtime_error(cut_.failed()[0].reason);
  show();
  return cut_;
}

}  // namespace swiftgs::cli
