// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>

#include <swiftgs/frame/backend.hpp>
#include <swiftgs/frame/frame_plan.hpp>
#include <swiftgs/frame/learnt.hpp>
#include <swiftgs/frame/placed_scene.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/frame/stages.hpp>
#include <swiftgs/frame/stored_scenes.hpp>
#include <swiftgs/frame/views.hpp>

namespace swiftgs {

/// The frame whose splats and tile lists `Stages` still holds.
struct LastFrame {
  enum class Kind { none, drawn, recorded } kind = Kind::none;
  Views views{};
  Span<const std::uint32_t> owners{};  ///< of the parts of views, as `PanoramaParts::owners`
  StoredScenes scenes{};
};

/// Draws frames on backend `B` with policies that are bound at run time: plans a frame, runs its stages, and
/// draws it again if a device's frame did not fit. It knows no feature: drivers that record, pick or measure
/// include it, and work by its hooks, its stages and its last frame.
///
/// It keeps the memory of its stages, so a frame no larger than an earlier one allocates nothing. All of it
/// is from the hook of its backend. It is not safe to use from two threads at once; two renderers are.
template <class B>
class FrameRenderer {
 public:
  FrameRenderer(B backend, const StageTable<B>& table, std::unique_ptr<SortStage<B>> sort)
      : stages_(std::move(backend), table, std::move(sort)) {
    use_memory_of(this->backend(), plan_memory_);
  }

  B& backend() { return stages_.backend(); }
  const B& backend() const { return stages_.backend(); }
  Stages<B>& stages() { return stages_; }
  const Stages<B>& stages() const { return stages_; }

  /// Renders any number of views of any number of placed scenes in one frame, into memory of the caller that
  /// the backend can reach: one projection, one sort, one rasterization. The images have the bits of frames
  /// of one view each. Cameras, sizes, conventions, backgrounds, formats and the placed scenes that show may
  /// differ from view to view; `make_view` makes views. Splats of all scenes are blended in the order of
  /// their depths; of equal ones the first scene's is in front. On a device it returns when the frame is in
  /// stream order, not when it is finished. Throws `InvalidArgument` for a view or scene that nothing
  /// can be rendered with, `CapacityError`, and `DeviceError` on a device.
  void render_into(const PlacedScenes& scenes, Span<const View> views, FrameHooks& hooks) {
    for (const View& view : views) validate(view);
    last_ = {};
    FramePlan plan = plan_frame(
        backend(), scenes, views, plan_memory_, [&](const StoredScenes& stored, Span<const View> cut) {
          return tiles_.choose(FrameKey::of(stored, cut), cut, may_gain_by_coarse_tiles());
        });
    if constexpr (B::reaches_host_memory) {
      stages_.run(plan, hooks);
      report_ = stages_.report(plan);
    } else {
      FrameCapacity& known = plan.views[0].grid.side == default_tile_side ? capacity_ : coarse_capacity_;
      report_ = known.draw_until_it_fits([&](const Capacity& capacity) {
        plan.limits = {capacity};
        stages_.run(plan, hooks);
        return stages_.report(plan);
      });
      stages_.set_intersections(report_.intersections);
    }
    tiles_.learn(report_.visible);
    gaussians_ = plan.scenes.gaussians();
    last_ = {LastFrame::Kind::drawn, plan.views, plan_memory_.planned.owners(), plan.scenes};
  }
  void render_into(const PlacedScenes& scenes, Span<const View> views) {
    NoHooks none;
    render_into(scenes, views, none);
  }

  /// What the last frame of `render_into` took, and Gaussians of its scenes.
  const FrameReport& report() const { return report_; }
  std::size_t gaussians() const { return gaussians_; }

  const LastFrame& last() const { return last_; }
  /// For drivers that run the stages themselves: tells what these hold now.
  void note(const LastFrame& frame) { last_ = frame; }
  /// For such drivers: later frames of a device begin with this capacity.
  void expect(const Capacity& capacity) { capacity_.at_least(capacity); }

  /// Gives back all memory that it and its backend keep, uploaded scenes excluded, after waiting for all work
  /// submitted so far. The next frame takes it again. The last frame is gone.
  void trim() {
    B& b = backend();
    b.wait();
    last_ = {};
    stages_.trim();
    trim_parts(b, plan_memory_);
    if constexpr (requires { b.trim(); }) b.trim();
    tiles_ = {}, capacity_ = {}, coarse_capacity_ = {};
  }

  /// Bytes that the buffers of each stage take in the backend's memory. Buffers grow with the largest frame
  /// so far, and are empty after `trim`.
  StageMemory memory() const {
    StageMemory memory = stages_.memory();
    memory.project += bytes_of(plan_memory_);
    return memory;
  }

  /// Whether coarser tiles than `default_tile_side` change no bit and may save time.
  bool may_gain_by_coarse_tiles() const {
    return stages_.table().raster.may_gain_by_coarse_tiles && stages_.table().bounds.conservative;
  }

 private:
  Stages<B> stages_;
  PlanMemory<B> plan_memory_;  ///< of `render_into`
  std::size_t gaussians_ = 0;
  FrameReport report_;      ///< of the last frame of `render_into`
  TileChoice tiles_;        ///< learnt from that frame
  FrameCapacity capacity_;  ///< of a device's frames
  /// Capacity of frames with coarse tiles: fewer intersections, so smaller launches.
  FrameCapacity coarse_capacity_;
  LastFrame last_;
};

}  // namespace swiftgs
