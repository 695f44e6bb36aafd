// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <tuple>
#include <vector>

#include <swiftgs/drivers/render_settings.hpp>
#include <swiftgs/drivers/statistics.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/frame/frame_renderer.hpp>
#include <swiftgs/frame/placed_scene.hpp>
#include <swiftgs/frame/raster.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/frame/stored_scenes.hpp>
#include <swiftgs/frame/views.hpp>

namespace swiftgs {

/// Draws frames, and measures what they take.
template <class B>
class FrameMeasures {
 public:
  /// As `FrameRenderer::render_into`.
  void render_into(FrameRenderer<B>& renderer, const PlacedScenes& scenes, Span<const View> views,
                   Measures asked) {
    Hooks hooks(renderer.backend(), asked, *this);
    renderer.render_into(scenes, views, hooks);
    timed_ = asked.time;
    if (!asked.count) return;
    Stages<B>& stages = renderer.stages();
    // As many as the renderer's report tells.
    hooks.drawn.splats = stages.splats().view(), hooks.drawn.lists = stages.lists().view();
    counted_ = stages.table().raster.count(stages.backend(), hooks.drawn);
  }

  /// Durations of the last frame's stages. Not a number unless they were asked for and the frame is finished:
  /// this does not wait. @units{milliseconds}
  StageTimes times(B& b) const {
    const auto ms = [&](std::size_t from, std::size_t to) {
      const std::optional<double> taken = timed_ ? b.milliseconds(points_[from], points_[to]) : std::nullopt;
      return taken.value_or(std::numeric_limits<double>::quiet_NaN());
    };
    return {ms(0, 1), ms(1, 2), ms(2, 3), ms(0, 3)};
  }

  /// What the last frame took.
  Statistics statistics(const FrameRenderer<B>& renderer) const {
    const FrameReport& report = renderer.report();
    return {.gaussians = renderer.gaussians(),
            .visible = std::size_t(report.visible),
            .intersections = std::size_t(report.intersections),
            .intersections_hidden = counted_.intersections_hidden,
            .raster = counted_.raster};
  }

  /// Forgets what was counted.
  void reset() { counted_ = {}; }

  static auto buffers(auto& self) { return std::tie(self.counts_); }

 private:
  class Hooks final : public FrameHooks {
   public:
    Hooks(B& b, Measures asked, FrameMeasures& to) : b_(b), asked_(asked), to_(to) {}
    void mark(std::size_t point) override {
      if (point == 0) to_.counted_ = {}, to_.timed_ = false;  // a frame that is refused leaves what was
      if (asked_.time) to_.points_[point] = b_.now();
    }
    void before_raster(RasterJob& job) override {
      if (!B::reaches_host_memory || !asked_.count) return;
      to_.counts_.reset(RasterBlocks(job.views.tiles).size());
      job.counts = to_.counts_.data();
    }
    void after_raster(const RasterJob& job) override { drawn = job; }

    RasterJob drawn;

   private:
    B& b_;
    Measures asked_;
    FrameMeasures& to_;
  };

  typename B::template Buffer<RasterCounts> counts_;  ///< of hosts
  std::array<typename B::TimePoint, 4> points_{};
  FrameCounted counted_;
  bool timed_ = false;
};

/// Splats of each placed scene in the last frame of `renderer`, which was not recorded, all views together.
/// Waits for the frame and copies 4 bytes a splat to the host. A panorama has a splat of a Gaussian in each
/// of its parts. Throws `OrderError` without such a frame.
template <class B>
std::vector<std::size_t> visible_by_scene(const FrameRenderer<B>& renderer) {
  const LastFrame& last = renderer.last();
  if (last.kind != LastFrame::Kind::drawn) throw OrderError("visible_by_scene: expected a frame before");
  std::vector<std::uint32_t> numbers(std::size_t(renderer.report().visible));
  const Stages<B>& stages = renderer.stages();
  stages.backend().download(stages.splats().view().gaussians.first(numbers.size()), numbers.data());
  std::vector<std::size_t> visible(last.scenes.size());
  const SeveralScenes scenes{last.scenes.each().data, std::uint32_t(last.scenes.size())};
  for (const std::uint32_t number : numbers)
    ++visible[std::size_t(&scenes.of_gaussian(number) - scenes.each)];
  return visible;
}

}  // namespace swiftgs
