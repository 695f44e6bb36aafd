// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/backend.hpp>
#include <swiftgs/frame/frame_plan.hpp>
#include <swiftgs/frame/frame_renderer.hpp>
#include <swiftgs/frame/learnt.hpp>
#include <swiftgs/frame/passes.hpp>
#include <swiftgs/frame/placed_scene.hpp>
#include <swiftgs/frame/stages.hpp>
#include <swiftgs/frame/stored_scenes.hpp>
#include <swiftgs/frame/tiles.hpp>
#include <swiftgs/frame/views.hpp>

namespace swiftgs {

/// Views and placed scenes of recorded frames on backend `B`, and their reservation. Until the next
/// reservation, only data that replayed work reads from memory may change. Its members take one renderer.
template <class B>
class RecordedFrames {
 public:
  /// Takes all memory that `record` needs for frames of `views` and `scenes`. `set_views` may later set other
  /// views of the same sizes, `set_scenes` move placed scenes, and a scene alone may change. The default
  /// capacity is an eighth more than the views show now, at most all Gaussians in all views and
  /// `max_intersections`. A capacity counts intersections with the tiles of these views; frames that are not
  /// recorded may use coarser tiles, and their `statistics` are then too small. Draws nothing and waits. If
  /// it throws, `record` is refused until it succeeds.
  void reserve(FrameRenderer<B>& renderer, const PlacedScenes& scenes, Span<const View> views,
               Capacity capacity = {}) {
    renderer.note({});
    Stages<B>& stages = renderer.stages();
    prepare(stages.backend(), scenes, views);
    FramePlan plan(views_, scenes_);
    const auto rehearse = [&](const Capacity& within) {
      plan.limits = {within, false};
      NoHooks none;
      stages.run(plan, none);
      return stages.report(plan);
    };
    if (capacity.splats == 0 || capacity.intersections == 0) {
      // A host counts only the intersections of splats within the capacity.
      const FrameReport report = rehearse(B::reaches_host_memory ? Capacity{} : Capacity{1, 1});
      check_intersections(report.intersections);
      if (capacity.splats == 0) capacity.splats = with_spare(report.visible);
      if (capacity.intersections == 0) capacity.intersections = with_spare(report.intersections);
    }
    capacity.splats = std::min(capacity.splats, std::max<std::size_t>(plan.candidates(), 1));
    capacity.intersections = std::min(capacity.intersections, std::size_t(max_intersections));
    const Reservation reserved{scenes_.gaussians(), scenes_.chunks(), views_.size(), views_.tiles, capacity};
    if constexpr (B::reaches_host_memory) {
      stages.reserve(reserved, plan.passes);
    } else {
      // Twice, because buffers change places.
      for (int k = 0; k < 2; ++k) rehearse(capacity);
      renderer.expect(capacity);
    }
    reserved_ = reserved;
  }

  /// Sets the views that `record` renders, in stream order. Recorded work that runs again renders them too.
  /// Between `reserve` calls, cameras, conventions, backgrounds, formats and the addresses of planes may
  /// change; lenses and orders may change if a reserved view is no pinhole or takes another depth than z.
  /// Throws `InvalidArgument`, and changes nothing, if more changes: the number of views, a size, which
  /// placed scenes show, which planes a frame has, whether it converts colours, as frames of linear scenes
  /// do.
  void set_views(B& b, Span<const View> views) { take_views(b, views, scenes_); }

  /// Sets what `record(renderer, report)` renders, in stream order: the placed scenes of the latest
  /// `reserve`, moved, clipped, tinted or made fainter, or others of as many Gaussians and of the same
  /// models. Recorded work that runs again renders them too. Throws `InvalidArgument`, and changes
  /// nothing, if more changes, or if `reserve` was for a scene alone (one placed scene where it stands by
  /// itself is that).
  void set_scenes(B& b, const PlacedScenes& scenes) {
    for (const PlacedScene& placed : scenes.each()) validate(placed);
    detail::require_for_render(reserved_.has_value(), "reserve before set_scenes");
    if (alone_ || scenes.size() != scenes_.size())
      detail::refuse("set_scenes: the number of placed scenes is ", scenes.size(), ", expected ",
                     alone_ ? "a scene alone" : std::to_string(scenes_.size()), " as reserved");
    for (std::size_t i = 0; i < scenes.size(); ++i)
      if (scenes.each()[i].size() != scenes_.each()[i].size())
        detail::refuse("set_scenes: placed scene ", i, " has ", scenes.each()[i].size(),
                       " Gaussians, expected ", scenes_.each()[i].size(), " as reserved");
    check_models(scenes);
    for (const View& view : views_.each) check_shown(scenes, view);
    check_ready(b);
    scenes_ = store_scenes(b, scenes, views_.each, memory_.scenes, ViewAccess::stored);
  }

  /// The placed scenes that `record(renderer, report)` renders, in memory of the backend, until the next
  /// `reserve`: work in stream order may write poses, opacities, clips and tints there, and nothing else, for
  /// frames that are recorded or run again later, until the next `set_scenes`. A device does not draw a scene
  /// that is not valid (NaN, no rotation), see `refused_scenes`; a host throws. Throws `OrderError` unless
  /// placed scenes were reserved: one scene where it stands by itself is drawn as a scene alone.
  Span<StoredScene> stored_scenes() const {
    if (!reserved_ || alone_) throw OrderError("recorded_scenes: expected reserve of placed scenes before");
    return {const_cast<StoredScene*>(scenes_.reachable()), scenes_.size()};
  }
  /// Indices of placed scenes that the last recorded frame should have shown and refused to draw. Waits for
  /// the frame.
  std::vector<std::size_t> refused_scenes(const B& b) const {
    std::vector<std::size_t> refused;
    if (!scenes_.is_on_device()) return refused;
    std::vector<StoredScene> now(scenes_.size());
    b.download(Span<const StoredScene>{scenes_.reachable(), now.size()}, now.data());
    for (std::size_t i = 0; i < now.size(); ++i)
      if (now[i].refused != 0) refused.push_back(i);
    return refused;
  }

  /// Renders the views that were set. It never waits, allocates or queries the device, so a CUDA graph may
  /// capture it. Writes what the frame took to `report`, in memory that the backend reaches. A frame above
  /// the capacity draws nothing. Call `reserve` before. On hosts the frame is complete when it returns.
  /// Throws `InvalidArgument` where nothing can be rendered, and `CapacityError` where `reserve` was
  /// called for fewer Gaussians.
  ///
  /// Calls `before_raster()` between sort and rasterization, which alone reads the occluder and the
  /// image below: let the stream wait there until both are drawn. A host does not call it for a frame above
  /// the capacity.
  ///
  /// A captured graph works in the renderer's memory. It must not be launched again after `reserve`, the
  /// renderer's `trim` or a larger frame of `render_into`, which move that memory.
  template <class BeforeRaster>
  void record(FrameRenderer<B>& renderer, const SceneView& scene, FrameReport* report,
              const BeforeRaster& before_raster) {
    for (const View& view : views_.each)
      detail::require_for_render(StoredScenes(scene).shown(view).size == 1, "views that show the scene");
    record_scenes(renderer, scene, report, before_raster);
  }
  /// Renders the scenes of `reserve` or `set_scenes` likewise.
  template <class BeforeRaster>
  void record(FrameRenderer<B>& renderer, FrameReport* report, const BeforeRaster& before_raster) {
    record_scenes(renderer, scenes_, report, before_raster);
  }

  static auto buffers(auto& self) { return std::tie(self.memory_); }

 private:
  template <class BeforeRaster>
  void record_scenes(FrameRenderer<B>& renderer, const StoredScenes& scenes, FrameReport* report,
                     const BeforeRaster& before_raster) {
    struct Hooks final : FrameHooks {
      const BeforeRaster& call;
      explicit Hooks(const BeforeRaster& of) : call(of) {}
      void before_raster(RasterJob&) override { call(); }
    };
    const FramePlan frame = plan(scenes, report);
    renderer.note({});
    Hooks hooks(before_raster);
    renderer.stages().run(frame, hooks);
    if constexpr (B::reaches_host_memory)
      if (report->overflowed != 0) return;  // its lists were not made
    renderer.note({LastFrame::Kind::recorded, views_, memory_.planned.owners(), {}});
  }

  /// Takes what to reserve for. Nothing is reserved until `reserve` ends.
  void prepare(B& b, const PlacedScenes& scenes, Span<const View> views) {
    reserved_.reset();
    for (const PlacedScene& placed : scenes.each()) validate(placed);
    take_views(b, views, scenes);
    scenes_ = {}, alone_ = scenes.is_alone();
    models_.clear();
    for (const PlacedScene& placed : scenes.each()) models_.push_back(placed.scene.model);
    scenes_ =
        store_scenes(b, scenes, views_.each, memory_.scenes, alone_ ? ViewAccess::any : ViewAccess::stored);
  }

  /// A frame of `scenes` that reports to `report`. Throws `InvalidArgument` if nothing is reserved, and
  /// `CapacityError` if it was reserved for fewer Gaussians.
  FramePlan plan(const StoredScenes& scenes, FrameReport* report) const {
    detail::require_for_render(reserved_ && views_.size() != 0, "reserve before record");
    detail::require_for_render(report != nullptr, "memory for the report");
    check_models(scenes);
    if (scenes.gaussians() > reserved_->gaussians)
      throw CapacityError("Gaussians in a recorded frame", scenes.gaussians(), reserved_->gaussians);
    return FramePlan(views_, scenes, {reserved_->capacity, true, report});
  }

  void take_views(B& b, Span<const View> views, const auto& scenes) {
    for (const View& view : views) validate(view), detail::check_tiles(view);
    PlannedViews planned;
    views = planned.of(views, scenes);
    if (reserved_) check_suits(views);
    check_ready(b);
    const bool through_lens = reserved_ && views_.through_lens;
    views_ = {};
    views_ = store_views(b, views, memory_.views, ViewAccess::stored);
    views_.through_lens |= through_lens;
    memory_.planned = std::move(planned);
  }

  /// Stored views follow the models of the scenes that were reserved for.
  void check_models(const auto& scenes) const {
    for (std::size_t i = 0; i < scenes.size() && i < models_.size(); ++i)
      if (scenes.each()[i].scene.model != models_[i])
        detail::refuse("render: placed scene ", i,
                       " was trained for another rendering model, expected that of the one reserved for");
  }

  void check_suits(Span<const View> views) const {
    if (views.size != views_.size())
      detail::refuse("set_views: the number of views is ", views.size, ", expected ", views_.size(),
                     " as reserved");
    for (std::size_t i = 0; i < views.size; ++i) {
      if (!same_shape(views[i], views_[i]))
        detail::refuse("set_views: the size, the planes or the conversion of colours of view ", i,
                       " changed, expected those that were reserved");
      if (views[i].camera.through_lens && !views_.through_lens)
        detail::refuse("set_views: view ", i,
                       " is no pinhole that takes depth z alone, by its lens, depth or order; expected those "
                       "as reserved");
    }
  }

  /// Whether frames of `a` and `b` have the same size, placed scenes and planes, and both or neither convert
  /// colours.
  static bool same_shape(const View& a, const View& b) {
    bool same = a.frame.width == b.frame.width && a.frame.height == b.frame.height &&
                a.grid.side == b.grid.side && a.request == b.request;
    same = same && a.frame.feature_channels == b.frame.feature_channels;
    same = same && (a.frame.conversion == Conversion::as_is) == (b.frame.conversion == Conversion::as_is);
    same = same && a.shows.first == b.shows.first && a.shows.count == b.shows.count;
    return same && attribute_count(a) == attribute_count(b);
  }

  PlanMemory<B> memory_;
  Views views_;                         ///< in `memory_`
  StoredScenes scenes_;                 ///< likewise
  bool alone_ = false;                  ///< whether the reservation was for a scene alone
  std::vector<RenderingModel> models_;  ///< of the scenes of the reservation
  std::optional<Reservation> reserved_;
};

}  // namespace swiftgs
