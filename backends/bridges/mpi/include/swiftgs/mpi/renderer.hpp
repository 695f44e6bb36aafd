// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include <swiftgs/drivers/render_settings.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/frame/placed_scene.hpp>
#include <swiftgs/mpi/counters.hpp>
#include <swiftgs/mpi/joint_frame.hpp>
#include <swiftgs/mpi/ranks.hpp>
#include <swiftgs/mpi/strip_frames.hpp>
#include <swiftgs/mpi/strips.hpp>
#include <swiftgs/renderer.hpp>

namespace swiftgs {

/// Renders frames of placed scenes whose parts lie on the ranks. Each rank projects its own Gaussians,
/// sends splats to the ranks whose strips they touch, and draws its own strip by the stages of `Renderer`.
/// The bits are those of one `Renderer` that draws the same parts rank by rank.
///
/// Part r of a scene holds Gaussians that follow those of part r - 1 in the order of the scene (`part_of`).
/// With several placed scenes each rank gives its parts of all, placed alike: Gaussians are numbered rank by
/// rank, and of equal depths the lower rank's is in front. All functions that render are collective, and all
/// ranks ask for the same planes of the same views; the orders and colours that these leave to the scenes
/// must agree. If one rank fails, all throw: that rank its own error, the others `RankError`; the renderers
/// stay usable. After an `MpiError` the program must end.
template <class B, class Sort = EarlySort, class Raster = AxisSharedThreshold<FloatCholesky>,
          class Bounds = Ellipse>
requires(detail::check_policies<B, Sort, Raster, Bounds>()) class DistributedRenderer {
 public:
  /// As of `Renderer`.
  static constexpr std::string_view name = Renderer<B, Sort, Raster, Bounds>::name;

  /// Collective. Throws `InvalidArgument` on all ranks if their builds of the program, or their
  /// renderers, differ, and `MpiError` if devices cannot be joined, after which the program has to end.
  explicit DistributedRenderer(Ranks ranks, B backend = B(), Sort sort = Sort())
      : frame_(std::move(ranks),
               std::make_unique<Renderer<B, Sort, Raster, Bounds>>(std::move(backend), std::move(sort))) {}

  const Ranks& ranks() const { return frame_.ranks(); }
  B& backend() { return frame_.backend(); }
  const B& backend() const { return frame_.one().backend(); }
  /// What brings splats from rank to rank: "host", which is MPI, or the name of a `DirectLink`.
  std::string_view carrier() const { return frame_.carrier(); }

  /// Renders into this rank's memory for whole views, which its backend reaches. Reads and writes only the
  /// pixels of its strip, see `drawn`. Finished when it returns. Throws as `Renderer::render_into`, and
  /// `RankError`.
  void render_into(const PlacedScenes& part, Span<const View> views) {
    Failure failure;
    failure.guard([&] {
      for (const View& view : views) validate(view);
    });
    const auto provide = [&] {
      for (DrawnStrip& each : frame_.drawn())
        each.frame = each.view_strip.pixels_of(views[each.view_strip.view].frame);
    };
    draw(part, views, failure, provide, [] {});
  }

  /// Renders a view a camera into memory of the backend that the renderer keeps until the next call, each
  /// rank its strip. Returns and throws as `render_into`.
  Span<const DrawnStrip> render_strips(const PlacedScenes& part, Span<const Camera> cameras,
                                       const RenderSettings& settings) {
    Failure failure;
    failure.guard([&] { make_views(part, cameras, settings); });
    const auto provide = [&] { frame_.frames().keep(backend(), settings.outputs, frame_.drawn()); };
    draw(part, {views_.data(), views_.size()}, failure, provide, [] {});
    return drawn();
  }

  /// Renders a frame a camera and collects them on rank 0, on the host. `frames` has as many there, and is
  /// not looked at on other ranks. Throws as `render_into`.
  void render(const PlacedScenes& part, Span<const Camera> cameras, const RenderSettings& settings,
              Span<Frame> frames) {
    const bool collects = ranks().rank() == 0;
    std::vector<FrameView> whole;
    Failure failure;
    failure.guard([&] {
      make_views(part, cameras, settings);
      if (collects && frames.size != cameras.size)
        detail::refuse("render: the number of frames is ", frames.size, ", expected ", cameras.size,
                       ", one a camera");
      for (std::size_t i = 0; collects && i < frames.size; ++i)
        whole.push_back(prepare(frames[i], cameras[i].width, cameras[i].height, settings.outputs));
    });
    const auto provide = [&] {
      if (B::reaches_host_memory && collects)
        for (DrawnStrip& each : frame_.drawn())
          each.frame = each.view_strip.pixels_of(whole[each.view_strip.view]);
      else
        frame_.frames().keep(backend(), settings.outputs, frame_.drawn());
      if (collects) frame_.frames().expect(frame_.strips(), frames);
    };
    draw(part, {views_.data(), views_.size()}, failure, provide,
         [&] { frame_.frames().to_host(backend(), ranks(), frame_.drawn(), frames); });
    frame_.frames().collect(ranks(), frame_.strips());
  }
  void render(const PlacedScenes& part, const Camera& camera, const RenderSettings& settings, Frame& frame) {
    render(part, {&camera, 1}, settings, {&frame, 1});
  }

  /// Strips of the last frame that this rank has drawn: none if the ranks outnumber the rows of tiles.
  Span<const DrawnStrip> drawn() const { return {frame_.drawn().data(), frame_.drawn().size()}; }

  /// Counters of all ranks for the last frame; the same on all ranks. Empty if the frame failed.
  const FrameCounters& counters() const { return counters_; }

  /// Memory that this rank's stages and exchange take of the backend's. @units{bytes}
  std::size_t memory() const { return frame_.memory(); }

 private:
  void make_views(const PlacedScenes& part, Span<const Camera> cameras, const RenderSettings& settings) {
    swiftgs::make_views(cameras, settings, views_);
    require_features(part, settings.outputs.features);  // before memory is taken for them
  }

  /// One frame. `provide` gives the view strips of `drawn` memory; `finish` is called when they are drawn.
  template <class Provide, class Finish>
  void draw(const PlacedScenes& part, Span<const View> views, Failure& failure, const Provide& provide,
            const Finish& finish) {
    frame_.drawn().clear(), counters_ = {};
    try {
      if (ranks().size() == 1)
        draw_alone(part, views, failure, provide, finish);
      else
        counters_ = frame_.draw(part, views, failure, provide, finish);
    } catch (...) {
      frame_.forget();
      throw;
    }
  }

  /// Draws the frame on a rank alone, whose strip is the whole frame.
  template <class Provide, class Finish>
  void draw_alone(const PlacedScenes& scene, Span<const View> views, const Failure& failure,
                  const Provide& provide, const Finish& finish) {
    failure.agree(ranks());
    using Clock = std::chrono::steady_clock;
    const Clock::time_point begun = Clock::now();
    BoundRenderer<B>& one = frame_.one();
    std::vector<DrawnStrip>& drawn = frame_.drawn();
    std::vector<View> all(views.begin(), views.end());
    for (const View& view : views)
      drawn.push_back(
          {{.view = std::uint32_t(drawn.size()), .rows = view.frame.height, .width = view.frame.width}});
    provide();
    for (std::size_t i = 0; i < all.size(); ++i) all[i].frame = drawn[i].frame;
    one.render_into(scene, {all.data(), all.size()}, {.count = false, .time = true});
    backend().wait();
    finish();
    const Statistics found = one.statistics();
    const StageTimes times = one.times();
    RankCounters mine{.gaussians = found.gaussians, .visible = found.visible, .drawn = found.visible};
    mine.intersections = found.intersections, mine.rows = one.tiles().rows, mine.bytes = memory();
    mine.project_ns = std::uint64_t(1e6 * times.project);
    mine.strip_ns = std::uint64_t(1e6 * (times.sort + times.raster));
    mine.frame_ns = std::uint64_t(std::chrono::nanoseconds(Clock::now() - begun).count());
    counters_ = {{mine}};
  }

  JointFrame<B, Bounds> frame_;
  std::vector<View> views_;  ///< of cameras
  FrameCounters counters_;
};

}  // namespace swiftgs
