// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include <swiftgs/attribute_stage.hpp>
#include <swiftgs/backend.hpp>
#include <swiftgs/camera.hpp>
#include <swiftgs/count.hpp>
#include <swiftgs/frame.hpp>
#include <swiftgs/frame_capacity.hpp>
#include <swiftgs/frame_plan.hpp>
#include <swiftgs/message.hpp>
#include <swiftgs/modelled_views.hpp>
#include <swiftgs/pick_stage.hpp>
#include <swiftgs/placed_scene.hpp>
#include <swiftgs/recorded_frames.hpp>
#include <swiftgs/resident_frames.hpp>
#include <swiftgs/stages.hpp>
#include <swiftgs/statistics.hpp>
#include <swiftgs/tile_choice.hpp>

namespace swiftgs {

/// The stages that policies choose.
template <class B>
struct StagePolicies {
  BoundsStages<B> bounds;
  std::unique_ptr<SortStage<B>> sort;
  RasterStage<B> raster;
};

namespace detail {
struct DoNothing {
  void operator()() const {}
};
}  // namespace detail

/// A renderer on backend `B` whose other policies are bound to it at run time: what all `Renderer`s on `B`
/// share.
///
/// It keeps the memory of its stages, so a frame no larger than an earlier one allocates nothing. All of it
/// is from the hook of its backend. It is not safe to use from two threads at once; two renderers are.
template <class B>
class BoundRenderer {
 public:
  BoundRenderer(B backend, StagePolicies<B> policies)
      : stages_(std::move(backend), policies.bounds, std::move(policies.sort)), raster_(policies.raster) {
    use_memory_of(this->backend(), raster_counts_, attributes_, view_storage_, scene_storage_, recorded_,
                  resident_, picking_);
  }

  B& backend() { return stages_.backend(); }
  const B& backend() const { return stages_.backend(); }
  /// For drivers of your own.
  Stages<B>& stages() { return stages_; }

  /// Renders into memory of the caller that the backend can reach. On a device it returns when the frame is
  /// in stream order, not when it is finished. Throws `std::invalid_argument` for a camera, scene or frame
  /// that nothing can be rendered with, `CapacityError`, and `DeviceError` on a device.
  void render_into(const PlacedScenes& scenes, const Camera& camera, const RenderSettings& settings,
                   const FrameView& frame) {
    validate(settings);
    detail::require_for_render(frame.width == camera.width && frame.height == camera.height,
                               "a frame of the camera's size");
    const View view = make_view(camera, settings.conventions, frame, settings.background);
    render_into(scenes, Span{&view, 1}, {settings.count, settings.time});
  }

  /// Renders any number of views of any number of placed scenes in one frame: one projection, one sort, one
  /// rasterization. The images have the bits of frames of one view each. Cameras, sizes, conventions,
  /// backgrounds, formats and the placed scenes that show may differ from view to view; `make_view` makes
  /// views. Splats of all scenes are blended in the order of their depths; of equal ones the first scene's is
  /// in front. Returns and throws as above.
  void render_into(const PlacedScenes& asked, Span<const View> views, Measures measures = {}) {
    for (const View& view : views) validate(view);
    last_ = LastFrame::none;
    views = modelled_.of(parts_.of(views), asked);
    check_ready(backend());
    const PlacedScenes scenes = store_scenes(backend(), asked, views, scene_storage_);
    const FrameKey key = FrameKey::of(scenes, views);
    if (may_gain_by_coarse_tiles()) views = tiles_.choose(key, views);
    counted_ = {}, timed_ = false;
    FramePlan plan(store_views(backend(), views, view_storage_), scenes);
    RasterJob drawn;
    if constexpr (B::reaches_host_memory) {
      drawn = run(plan, measures);
      report_ = stages_.report(plan);
    } else {
      FrameCapacity& known = views[0].grid.side == default_tile_side ? capacity_ : coarse_capacity_;
      report_ = known.draw_until_it_fits([&](const Capacity& capacity) {
        plan.limits = {capacity};
        drawn = run(plan, measures);
        return stages_.report(plan);
      });
      stages_.set_intersections(report_.intersections);
    }
    tiles_.learn(key, report_.visible);
    timed_ = measures.time;
    if (measures.count) {
      drawn.splats = stages_.splats().view(), drawn.lists = stages_.lists().view();  // as many as reported
      counted_ = raster_.count(backend(), drawn);
    }
    gaussians_ = scenes.gaussians();
    drawn_ = plan.views, drawn_scenes_ = plan.scenes, last_ = LastFrame::drawn;
  }

  /// Takes all memory that `record` needs for frames of `views` and `scenes`. `set_views` may later set other
  /// views of the same sizes, `set_scenes` move placed scenes, and a scene alone may change. The default
  /// capacity is an eighth more than the views show now, at most all Gaussians in all views and
  /// `max_intersections`. A capacity counts intersections with the tiles of these views; `render_into` may
  /// use coarser tiles, and its `statistics` are then too small. Draws nothing and waits. If it throws,
  /// `record` is refused until it succeeds.
  void reserve(const PlacedScenes& scenes, Span<const View> views, Capacity capacity = {}) {
    last_ = LastFrame::none;
    recorded_.prepare(backend(), scenes, views);
    FramePlan plan(recorded_.views(), recorded_.scenes());
    const auto rehearse = [&](const Capacity& within) {
      plan.limits = {within, false};
      run(plan, {});
      return stages_.report(plan);
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
    const Reservation reserved = recorded_.reservation(capacity);
    if constexpr (B::reaches_host_memory) {
      stages_.reserve(reserved);
      attributes_.reserve(recorded_.views(), reserved);
    } else {
      // Twice, because buffers change places.
      for (int k = 0; k < 2; ++k) rehearse(capacity);
      capacity_.at_least(capacity);
    }
    recorded_.reserve(reserved);
  }

  /// Sets the views that `record` renders, in stream order. Recorded work that runs again renders them too.
  /// Between `reserve` calls, cameras, conventions, backgrounds, formats and the addresses of planes may
  /// change; lenses and orders may change if a reserved view is no pinhole or takes another depth than z.
  /// Throws `std::invalid_argument`, and changes nothing, if more changes: the number of views, a size, which
  /// placed scenes show, which planes a frame has, whether it converts colours, as frames of linear scenes
  /// do.
  void set_views(Span<const View> views) { recorded_.set_views(backend(), views); }

  /// Sets what `record(report)` renders, in stream order: the placed scenes of the latest `reserve`, moved,
  /// clipped, tinted or made fainter, or others of as many Gaussians and of the same models. Recorded work
  /// that runs again renders them too. Throws `std::invalid_argument`, and changes nothing, if more changes,
  /// or if `reserve` was for a scene alone (one placed scene where it stands by itself is that).
  void set_scenes(const PlacedScenes& scenes) { recorded_.set_scenes(backend(), scenes); }

  /// The placed scenes that `record(report)` renders, in memory of the backend, until the next `reserve` or
  /// `trim`: work in stream order may write poses, opacities, clips and tints there, and nothing else, for
  /// frames that are recorded or run again later. A device does not draw a scene that is not valid (NaN, no
  /// rotation), see `refused_scenes`; a host throws. Null on a device for a scene alone.
  PlacedScene* recorded_scenes() { return recorded_.stored_scenes(); }
  /// Indices of placed scenes that the last recorded frame should have shown and refused to draw. Waits for
  /// the frame.
  std::vector<std::size_t> refused_scenes() const { return recorded_.refused_scenes(backend()); }

  /// Renders the views that were set. It never waits, allocates or queries the device, so a CUDA graph may
  /// capture it. Writes what the frame took to `report`, in memory that the backend reaches. A frame above
  /// the capacity draws nothing. Call `reserve` before. On hosts the frame is complete when it returns.
  /// Throws `std::invalid_argument` where nothing can be rendered, and `CapacityError` where `reserve` was
  /// called for fewer Gaussians.
  ///
  /// Calls `before_raster()` between sort and rasterization, which alone reads the occluder and the
  /// image below: let the stream wait there until both are drawn. A host does not call it for a frame above
  /// the capacity.
  ///
  /// A captured graph works in the renderer's memory. It must not be launched again after `reserve`, `trim`
  /// or a larger frame of `render_into`, which move that memory.
  template <class BeforeRaster = detail::DoNothing>
  requires std::invocable<const BeforeRaster&>
  void record(const SceneView& scene, FrameReport* report, const BeforeRaster& before_raster = {}) {
    for (const View& view : recorded_.views().each)
      detail::require_for_render(PlacedScenes(scene).shown(view).size == 1, "views that show the scene");
    record_scenes(scene, report, before_raster);
  }
  /// Renders the scenes of `reserve` or `set_scenes` likewise.
  template <class BeforeRaster = detail::DoNothing>
  requires std::invocable<const BeforeRaster&>
  void record(FrameReport* report, const BeforeRaster& before_raster = {}) {
    record_scenes(recorded_.scenes(), report, before_raster);
  }

  /// Gives back all memory that the renderer and its backend keep, uploaded scenes excluded, after waiting
  /// for all work submitted so far. The next frame takes it again. Views that were set and what was reserved
  /// are forgotten, so `record` is refused until the next `reserve`. Frames of `render_resident`, `splats`,
  /// `lists`, `tiles` and what `statistics` counts on request are gone.
  void trim() {
    B& b = backend();
    b.wait();
    last_ = LastFrame::none;
    stages_.trim();
    trim_parts(b, raster_counts_, attributes_, view_storage_, scene_storage_, recorded_, resident_, picking_);
    if constexpr (requires { b.trim(); }) b.trim();
    views_ = {}, parts_ = {}, modelled_ = {}, tiles_ = {}, capacity_ = {}, coarse_capacity_ = {};
    counted_ = {};
  }

  /// Renders into memory of the backend that the renderer keeps: the frames, one a camera, hold until the
  /// next call. Returns and throws as `render_into`.
  Span<const FrameView> render_resident(const PlacedScenes& scenes, Span<const Camera> cameras,
                                        const RenderSettings& settings) {
    make_views(cameras, settings, views_);
    require_features(scenes, settings.outputs.features);  // before memory is taken for them
    check_ready(backend());
    const Span<const FrameView> frames = resident_.make(cameras, settings.outputs);
    for (std::size_t i = 0; i < frames.size; ++i) views_[i].frame = frames[i];
    render_into(scenes, {views_.data(), views_.size()}, {settings.count, settings.time});
    return frames;
  }
  FrameView render_resident(const PlacedScenes& scenes, const Camera& camera,
                            const RenderSettings& settings) {
    return render_resident(scenes, {&camera, 1}, settings)[0];
  }

  /// Renders a frame a camera on the host; complete when it returns.
  void render(const PlacedScenes& scenes, Span<const Camera> cameras, const RenderSettings& settings,
              Span<Frame> frames) {
    if (frames.size != cameras.size)
      detail::refuse("render: the number of frames is ", frames.size, ", expected ", cameras.size,
                     ", one a camera");
    const auto prepare_frame = [&](std::size_t i) {
      return prepare(frames[i], cameras[i].width, cameras[i].height, settings.outputs);
    };
    if constexpr (B::reaches_host_memory) {
      make_views(cameras, settings, views_);
      require_features(scenes, settings.outputs.features);
      for (std::size_t i = 0; i < cameras.size; ++i) views_[i].frame = prepare_frame(i);
      render_into(scenes, {views_.data(), views_.size()}, {settings.count, settings.time});
    } else {
      render_resident(scenes, cameras, settings);
      for (std::size_t i = 0; i < cameras.size; ++i) prepare_frame(i);
      resident_.download(backend(), frames);
    }
  }
  void render(const PlacedScenes& scenes, const Camera& camera, const RenderSettings& settings,
              Frame& frame) {
    render(scenes, {&camera, 1}, settings, {&frame, 1});
  }
  Frame render(const PlacedScenes& scenes, const Camera& camera, const RenderSettings& settings = {}) {
    Frame frame;
    render(scenes, camera, settings, frame);
    return frame;
  }

  /// Which Gaussians pixels of the last frame show, by rows, from its splats and tile lists. Waits for the
  /// frame. `pick` does not look at occluders: compare depths with yours.
  ///
  /// The last frame is that of the latest `render_into`, `render_resident`, `render` or `record`. Results are
  /// undefined after the replay of a graph that does not hold the latest `record`, and between `set_views`
  /// and the next replay. A recorded frame above its capacity shows nothing on a device, and is no frame on a
  /// host.
  ///
  /// Throws `std::logic_error` if there is no frame: before the first, after `reserve` and `trim`, and after
  /// one that failed once its views were valid; `std::invalid_argument` for an unknown view, or a rectangle
  /// that does not lie in its frame; and `DeviceError` on a device.
  std::vector<PickedPixel> pick(const PickRectangle& rectangle) {
    check_ready(backend());
    const bool drawn = last_ == LastFrame::drawn;
    const Views& views = drawn ? drawn_ : recorded_.views();
    if (last_ == LastFrame::none || views.size() == 0)
      throw std::logic_error("pick: expected a frame before");
    return picking_.pick(stages_, views, drawn ? parts_ : recorded_.parts(), rectangle);
  }
  /// At one pixel, from the top left of the view's frame.
  PickedPixel pick(int x, int y, std::size_t view = 0) { return pick({.x = x, .y = y, .view = view})[0]; }

  /// Durations of the last frame's stages. Not a number unless the settings asked for them and the frame is
  /// finished: this does not wait. @units{milliseconds}
  StageTimes times() {
    const auto ms = [&](std::size_t from, std::size_t to) {
      const std::optional<double> taken =
          timed_ ? backend().milliseconds(points_[from], points_[to]) : std::nullopt;
      return taken.value_or(std::numeric_limits<double>::quiet_NaN());
    };
    return {ms(0, 1), ms(1, 2), ms(2, 3), ms(0, 3)};
  }

  /// What the last frame took.
  Statistics statistics() const {
    return {.gaussians = gaussians_,
            .visible = std::size_t(report_.visible),
            .intersections = std::size_t(report_.intersections),
            .intersections_hidden = counted_.intersections_hidden,
            .raster = counted_.raster};
  }

  /// Splats of each placed scene in the last frame of `render_into` or what calls it, all views together.
  /// Waits for the frame and copies 4 bytes a splat to the host. A panorama has a splat of a Gaussian in each
  /// of its parts. Throws `std::logic_error` without such a frame.
  std::vector<std::size_t> visible_by_scene() const {
    if (last_ != LastFrame::drawn) throw std::logic_error("visible_by_scene: expected a frame before");
    std::vector<std::uint32_t> numbers(std::size_t(report_.visible));
    backend().download(splats().view().gaussians.first(numbers.size()), numbers.data());
    std::vector<std::size_t> visible(drawn_scenes_.size());
    const SeveralScenes scenes{drawn_scenes_.each().data, std::uint32_t(drawn_scenes_.size())};
    for (const std::uint32_t number : numbers)
      ++visible[std::size_t(&scenes.of_gaussian(number) - scenes.each)];
    return visible;
  }

  /// Bytes that the buffers of each stage take in the backend's memory. Buffers grow with the largest frame
  /// so far, and are empty after `trim`.
  StageMemory memory() const {
    StageMemory memory = stages_.memory();
    memory.project += bytes_of(view_storage_, scene_storage_, recorded_);
    memory.raster += bytes_of(resident_, raster_counts_, attributes_, picking_);
    return memory;
  }

  /// Whether coarser tiles than `default_tile_side` change no bit and may save time.
  bool may_gain_by_coarse_tiles() const { return raster_.may_gain_by_coarse_tiles && stages_.conservative(); }

  /// The last frame's splats and tile lists, in the backend's memory, until the next frame; and its tiles.
  const Splats<B>& splats() const { return stages_.splats(); }
  const TileLists<B>& lists() const { return stages_.lists(); }
  const FrameTiles& tiles() const { return stages_.tiles(); }

 private:
  template <class BeforeRaster>
  void record_scenes(const PlacedScenes& scenes, FrameReport* report, const BeforeRaster& before_raster) {
    const FramePlan plan = recorded_.plan(scenes, report);
    last_ = LastFrame::none;
    run(plan, {}, before_raster);
    last_ = LastFrame::recorded;
    if constexpr (B::reaches_host_memory)
      if (report->overflowed != 0) last_ = LastFrame::none;  // its lists were not made
  }

  /// Returns what was rasterized; nothing if the frame does not fit the limits of a host.
  template <class BeforeRaster = detail::DoNothing>
  RasterJob run(const FramePlan& plan, const Measures& measures, const BeforeRaster& before_raster = {}) {
    if (B::reaches_host_memory && measures.count) raster_counts_.reset(RasterBlocks(plan.views.tiles).size());
    RasterJob drawn;
    stages_.run(
        plan, true,
        [&](RasterJob job) {
          if (measures.count) job.counts = raster_counts_.data();
          before_raster();
          attributes_.draw(backend(), plan.scenes, job, [&](const RasterJob& pass) {
            raster_.rasterize(backend(), pass);
            if (!pass.only_attributes) drawn = pass;
          });
        },
        [&](std::size_t point) {
          if (measures.time) points_[point] = backend().now();
        });
    return drawn;
  }

  Stages<B> stages_;
  RasterStage<B> raster_;
  typename B::template Buffer<RasterCounts> raster_counts_;  ///< of hosts
  AttributeStage<B> attributes_;
  ViewStorage<B> view_storage_;    ///< of `render_into`
  SceneStorage<B> scene_storage_;  ///< likewise
  RecordedFrames<B> recorded_;
  ResidentFrames<B> resident_;
  PickStage<B> picking_;
  PanoramaParts parts_;      ///< of the last frame that was not recorded
  ModelledViews modelled_;   ///< of the views in `parts_`
  std::vector<View> views_;  ///< of `render_resident` and `render`
  std::array<typename B::TimePoint, 4> points_{};
  FrameCounted counted_;
  bool timed_ = false;
  std::size_t gaussians_ = 0;
  FrameReport report_;      ///< of the last frame that was not recorded
  TileChoice tiles_;        ///< learnt from that frame
  FrameCapacity capacity_;  ///< of a device's frames
  /// Capacity of frames with coarse tiles: fewer intersections, so smaller launches.
  FrameCapacity coarse_capacity_;
  Views drawn_;                ///< in `view_storage_`
  PlacedScenes drawn_scenes_;  ///< in `scene_storage_`
  enum class LastFrame { none, drawn, recorded } last_ = LastFrame::none;
};

}  // namespace swiftgs
