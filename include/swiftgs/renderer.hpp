// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <swiftgs/backend.hpp>
#include <swiftgs/bin_stage.hpp>
#include <swiftgs/bounds/bounds.hpp>
#include <swiftgs/camera.hpp>
#include <swiftgs/composed_name.hpp>
#include <swiftgs/count.hpp>
#include <swiftgs/frame.hpp>
#include <swiftgs/project_stage.hpp>
#include <swiftgs/raster/raster.hpp>
#include <swiftgs/render_input.hpp>
#include <swiftgs/shade_stage.hpp>
#include <swiftgs/sort/sort.hpp>
#include <swiftgs/statistics.hpp>
#include <swiftgs/tile_choice.hpp>
#include <swiftgs/view.hpp>

namespace swiftgs {

/// Policy `R` rasterizes on backend `B`, by its own kernel or by an overload that the backend offers.
template <class R, class B>
concept RastersOn = BackendPolicy<B> && requires(B& b, R raster, const RasterJob& job) {
  { R::name } -> std::convertible_to<std::string_view>;
  rasterize(b, raster, job);
};

/// Renders frames: project, shade, bin, sort, rasterize. Every combination of policies is one type.
///
/// A renderer keeps the memory of its stages, so a frame no larger than an earlier one allocates nothing. All
/// of it is from the hook of the backend that the renderer was made with. It is not safe to use from two
/// threads at once; two renderers are.
template <class B, class Sort, class Raster, class Bounds>
requires SortsOn<Sort, B, Bounds> && RastersOn<Raster, B>
class Renderer {
  static constexpr ComposedName name_storage{B::name, "/", Sort::name, "/", Raster::name, "/", Bounds::name};

 public:
  /// BACKEND/SORT/RASTER/BOUNDS
  static constexpr std::string_view name = name_storage.view();

  explicit Renderer(B backend = B(), Sort sort = Sort())
      : backend_(std::move(backend)), sort_(std::move(sort)) {
    std::apply([&](auto&... parts) { use_memory_of(backend_, parts...); }, parts());
  }

  B& backend() { return backend_; }
  const B& backend() const { return backend_; }
  Sort& sort() { return sort_; }
  const Sort& sort() const { return sort_; }

  /// Renders into memory of the caller that the backend can reach. On a device it returns when the frame is
  /// in stream order, not when it is finished. Throws `std::invalid_argument` for a camera, scene or frame
  /// that nothing can be rendered with, `CapacityError`, and `DeviceError` on a device.
  void render_into(const SceneView& scene, const Camera& camera, const RenderSettings& settings,
                   const FrameView& frame) {
    validate(camera);
    validate(settings);
    check_size(camera, frame);
    const View view = make_view(camera, settings.conventions, frame, settings.background);
    render_into(scene, Span{&view, 1}, {settings.count, settings.time});
  }

  /// Renders any number of views of a scene in one frame: one projection, one sort, one rasterization. The
  /// images have the bits of frames of one view each. Cameras, sizes, conventions, backgrounds and formats
  /// may differ from view to view; `make_view` makes them. Returns and throws as above.
  void render_into(const SceneView& scene, Span<const View> views, Measures measures = {}) {
    validate(scene);
    for (const View& view : views) validate(view);
    check_ready(backend_);
    const FrameKey key = FrameKey::of(scene, views);
    const bool may_be_coarse = may_gain_by_coarse_tiles<B, Raster> && Bounds::lossless;
    const Views stored =
        store_views(backend_, may_be_coarse ? tiles_.choose(key, views) : views, view_storage_);
    counted_ = timed_ = false;
    FrameReport report;
    if constexpr (B::reaches_host_memory) {
      enqueue(scene, stored, measures, {});
      report = await_report(backend_, splats_, footprints_, Limits{});
    } else {
      // Render within the room there is; where it did not suffice, nothing was drawn.
      const Capacity before = capacity_;
      try {
        for (;;) {
          const Limits limits{capacity_};
          enqueue(scene, stored, measures, limits);
          report = await_report(backend_, splats_, footprints_, limits);
          if (report.overflowed == 0) break;
          make_room(report);
        }
      } catch (...) {
        capacity_ = before;  // or the next frame would ask for the memory that this one did not get
        throw;
      }
      lists_.instances = std::size_t(report.instances);
    }
    report_ = report, tiles_.learn(key, report.visible);
    counted_ = measures.count, timed_ = measures.time;
    gaussians_ = scene.size();
  }

  /// Takes all memory that `record` needs for frames of `views` and `scene`. `set_views` may replace the
  /// views by others whose frames have the same sizes, and `scene` may change. Without a `capacity` it makes
  /// room for what the views show now and an eighth more, at most for all Gaussians in all views and for
  /// `max_instances`. A capacity counts instances on the tiles of these views; tiles of `render_into` may be
  /// coarser, and its `statistics` then too small. Draws nothing and waits. If it throws, `record` is refused
  /// until it succeeds.
  void reserve(const SceneView& scene, Span<const View> views, Capacity capacity = {}) {
    validate(scene);
    reserved_.reset();
    set_views(views);
    const auto rehearse = [&](const Capacity& within) {
      const Limits limits{within, false};
      enqueue(scene, recorded_, {}, limits);
      return await_report(backend_, splats_, footprints_, limits);
    };
    if (capacity.splats == 0 || capacity.instances == 0) {
      // A host counts the instances of those splats alone that it has room for.
      const FrameReport report = rehearse(B::reaches_host_memory ? Capacity{} : Capacity{1, 1});
      check_instances(report.instances);
      if (capacity.splats == 0) capacity.splats = with_room(report.visible);
      if (capacity.instances == 0) capacity.instances = with_room(report.instances);
    }
    capacity.splats = std::min(capacity.splats, std::max<std::size_t>(scene.size() * views.size, 1));
    capacity.instances = std::min(capacity.instances, std::size_t(max_instances));
    const FrameRoom room{scene.size(), views.size, frame_tiles(recorded_), capacity};
    if constexpr (B::reaches_host_memory) {
      reserve_parts(backend_, room, project_scratch_, splats_, footprints_, colours_, sort_scratch_, lists_);
    } else {
      // Twice, because buffers change places.
      for (int k = 0; k < 2; ++k) rehearse(capacity);
      capacity_.splats = std::max(capacity_.splats, capacity.splats);
      capacity_.instances = std::max(capacity_.instances, capacity.instances);
    }
    reserved_ = room;
  }

  /// Sets the views that `record` renders, in stream order. Recorded work that runs again renders them too.
  /// Between `reserve` calls, cameras, conventions, backgrounds, formats and the places of planes may change.
  /// Throws `std::invalid_argument`, and changes nothing, if the number of views, a size, or which planes
  /// there are changes.
  void set_views(Span<const View> views) {
    for (const View& view : views) validate(view);
    if (reserved_) {
      if (views.size != recorded_.size())
        detail::refuse("set_views: the number of views", views.size,
                       std::to_string(recorded_.size()) + " as reserved");
      for (std::size_t i = 0; i < views.size; ++i)
        if (!same_shape(views[i], recorded_[i]))
          throw std::invalid_argument("set_views: the size or the planes of view " + std::to_string(i) +
                                      " changed, expected those that were reserved");
    }
    check_ready(backend_);
    recorded_ = {};
    const Views stored = store_views(backend_, views, recorded_storage_, ViewAccess::stored);
    frame_tiles(stored);
    recorded_ = stored;
  }

  /// Renders the views that were set, and neither waits, allocates nor asks a device for anything, so that it
  /// may be captured into a CUDA graph. Writes what the frame took to `report`, in memory that the backend
  /// reaches. A frame without enough room draws nothing. Call `reserve` before. On hosts the frame is
  /// complete when it returns. Throws `std::invalid_argument` where nothing can be rendered, and
  /// `CapacityError` where `reserve` was called for fewer Gaussians.
  ///
  /// A captured graph works in the renderer's memory. It must not be launched again after `reserve`, `trim`
  /// or a larger frame of `render_into`, which move that memory.
  void record(const SceneView& scene, FrameReport* report) {
    validate(scene);
    detail::require_for_render(reserved_ && recorded_.size() != 0, "reserve before record");
    detail::require_for_render(report != nullptr, "memory for the report");
    if (scene.size() > reserved_->gaussians)
      throw CapacityError("Gaussians in a recorded frame", scene.size(), reserved_->gaussians);
    enqueue(scene, recorded_, {}, Limits{reserved_->capacity, true, report});
  }

  /// Gives back all memory that the renderer and its backend keep, uploaded scenes excluded, after waiting
  /// for all work submitted so far. The next frame takes it again. Views that were set and what was reserved
  /// are forgotten, so `record` is refused until the next `reserve`. Frames of `render_resident`, `splats`,
  /// `lists`, `tiles` and the raster part of `statistics` are gone.
  void trim() {
    backend_.wait();
    std::apply([&](auto&... parts) { trim_parts(backend_, parts...); }, parts());
    if constexpr (requires { backend_.trim(); }) backend_.trim();
    frames_ = {}, views_ = {}, tiles_ = {};
    counted_ = false;
    capacity_ = {1, 1};
    recorded_ = {};
    reserved_.reset();
  }

  /// Renders into memory of the backend that the renderer keeps: the frames, one a camera, hold until the
  /// next call. Returns and throws as `render_into`.
  Span<const FrameView> render_resident(const SceneView& scene, Span<const Camera> cameras,
                                        const RenderSettings& settings) {
    for (const Camera& camera : cameras) validate(camera);
    validate(settings);
    check_ready(backend_);
    std::size_t pixels = 0;
    for (const Camera& camera : cameras) pixels += std::size_t(camera.width) * std::size_t(camera.height);
    frame_.colour.reset(3 * pixels);
    frame_.alpha.reset(settings.outputs.alpha ? pixels : 0);
    frame_.depth.reset(settings.outputs.depth ? pixels : 0);
    frames_.clear(), views_.clear();
    std::size_t before = 0;
    for (const Camera& camera : cameras) {
      const auto width = std::ptrdiff_t(camera.width), size = std::ptrdiff_t(sizeof(float));
      FrameView frame{.width = camera.width, .height = camera.height};
      frame.colour = {frame_.colour.data() + 3 * before, 3 * width * size};
      if (settings.outputs.alpha) frame.alpha = {frame_.alpha.data() + before, width * size};
      if (settings.outputs.depth) frame.depth = {frame_.depth.data() + before, width * size};
      before += std::size_t(camera.width) * std::size_t(camera.height);
      frames_.push_back(frame);
      views_.push_back(make_view(camera, settings.conventions, frame, settings.background));
    }
    render_into(scene, {views_.data(), views_.size()}, {settings.count, settings.time});
    return {frames_.data(), frames_.size()};
  }
  FrameView render_resident(const SceneView& scene, const Camera& camera, const RenderSettings& settings) {
    return render_resident(scene, {&camera, 1}, settings)[0];
  }

  /// Renders a frame a camera on the host; complete when it returns.
  void render(const typename B::SceneOn& scene, Span<const Camera> cameras, const RenderSettings& settings,
              Span<Frame> frames) {
    if (frames.size != cameras.size)
      detail::refuse("render: the number of frames", frames.size,
                     std::to_string(cameras.size) + ", one a camera");
    for (const Camera& camera : cameras) validate(camera);
    validate(settings);
    const auto prepare_frame = [&](std::size_t i) {
      return prepare(frames[i], cameras[i].width, cameras[i].height, settings.outputs);
    };
    if constexpr (B::reaches_host_memory) {
      views_.clear();
      for (std::size_t i = 0; i < cameras.size; ++i)
        views_.push_back(make_view(cameras[i], settings.conventions, prepare_frame(i), settings.background));
      render_into(scene.view(), {views_.data(), views_.size()}, {settings.count, settings.time});
    } else {
      for (std::size_t i = 0; i < cameras.size; ++i) prepare_frame(i);
      render_resident(scene.view(), cameras, settings);
      std::size_t before = 0;
      for (Frame& frame : frames) {
        const auto download = [&](const auto& buffer, std::size_t channels, std::vector<float>& to) {
          if (!to.empty())
            backend_.download(Span<const float>{buffer.data() + channels * before, to.size()}, to.data());
        };
        download(frame_.colour, 3, frame.colour);
        download(frame_.alpha, 1, frame.alpha);
        download(frame_.depth, 1, frame.depth);
        before += frame.pixels();
      }
    }
  }
  void render(const typename B::SceneOn& scene, const Camera& camera, const RenderSettings& settings,
              Frame& frame) {
    render(scene, {&camera, 1}, settings, {&frame, 1});
  }
  Frame render(const typename B::SceneOn& scene, const Camera& camera, const RenderSettings& settings = {}) {
    Frame frame;
    render(scene, camera, settings, frame);
    return frame;
  }

  /// Durations of the last frame's stages. Not a number unless the settings asked for them and the frame is
  /// finished: this does not wait. @units{milliseconds}
  StageTimes times() {
    const auto ms = [&](std::size_t from, std::size_t to) {
      const std::optional<double> taken =
          timed_ ? backend_.milliseconds(points_[from], points_[to]) : std::nullopt;
      return taken.value_or(std::numeric_limits<double>::quiet_NaN());
    };
    return {ms(0, 1), ms(1, 2), ms(2, 3), ms(0, 3)};
  }

  /// What the last frame took; the raster part only where the settings asked to count, which is waited for.
  Statistics statistics() const {
    Statistics s{.gaussians = gaussians_,
                 .visible = std::size_t(report_.visible),
                 .instances = std::size_t(report_.instances),
                 .raster = {}};
    if (counted_) {
      std::vector<SquareCounts> squares(square_counts_.size());
      backend_.download(square_counts_.span(), squares.data());
      for (const SquareCounts& square : squares) s.raster += square;
    }
    return s;
  }

  /// What the buffers of each stage hold, in the backend's memory. They grow with the largest frame so far,
  /// and are empty after `trim`.
  StageMemory memory() const {
    return {bytes_of(view_storage_, recorded_storage_, project_scratch_, splats_, footprints_, colours_),
            bytes_of(sort_scratch_, lists_),
            bytes_of(frame_.colour, frame_.alpha, frame_.depth, square_counts_)};
  }

  /// The last frame's splats and tile lists, in the backend's memory, until the next frame; and its tiles.
  const Splats<B>& splats() const { return splats_; }
  const TileLists<B>& lists() const { return lists_; }
  const FrameTiles& tiles() const { return footprints_.tiles; }

 private:
  /// Whether frames of both have the same size, and planes for the same outputs.
  static bool same_shape(const View& a, const View& b) {
    const auto planes = [](const FrameView& frame) {
      return std::array{frame.colour.data != nullptr, frame.alpha.data != nullptr,
                        frame.depth.data != nullptr, frame.occluder.data != nullptr};
    };
    return a.frame.width == b.frame.width && a.frame.height == b.frame.height && a.grid.side == b.grid.side &&
           planes(a.frame) == planes(b.frame);
  }

  /// All that holds memory of the backend.
  auto parts() {
    return std::tie(project_scratch_, splats_, footprints_, colours_, sort_scratch_, lists_, square_counts_,
                    view_storage_, recorded_storage_, frame_.colour, frame_.alpha, frame_.depth);
  }

  void make_room(const FrameReport& report) {
    check_instances(report.instances);
    capacity_.splats = std::max(capacity_.splats, with_room(report.visible));
    const std::size_t instances = std::min(with_room(report.instances), std::size_t(max_instances));
    capacity_.instances = std::max(capacity_.instances, instances);
  }

  /// Starts all stages of a frame. A host leaves the last out where the frame does not fit the limits.
  void enqueue(const SceneView& scene, const Views& views, const Measures& measures, const Limits& limits) {
    const auto take_time = [&](std::size_t point) {
      if (measures.time) points_[point] = backend_.now();
    };
    const Squares squares(frame_tiles(views));
    SquareCounts* counts = nullptr;
    if (measures.count) square_counts_.reset(squares.size()), counts = square_counts_.data();

    take_time(0);
    const PlacedScene instance{scene};
    const FrameInput input{views, {&instance, 1}, limits};
    project(backend_, input, Bounds{}, project_scratch_, splats_, footprints_);
    Shading<B> shading = shade(backend_, input, splats_, colours_);
    bin(backend_, views, Bounds{}, splats_, footprints_, limits);
    take_time(1);
    if constexpr (B::reaches_host_memory)
      if (await_report(backend_, splats_, footprints_, limits).overflowed != 0) return;

    const FrameUse use = !limits.draw    ? FrameUse::rehearsed
                         : limits.report ? FrameUse::recorded
                                         : FrameUse::drawn;
    const SortJob<Bounds> job{splats_.view(), footprints_.view(), FrameKey::of(scene, views), use};
    sort_.build(backend_, job, Bounds{}, sort_scratch_, lists_);
    take_time(2);

    rasterize(backend_, Raster{}, RasterJob{splats_.view(), shading.finish(), lists_.view(), views, counts});
    take_time(3);
  }

  static void check_size(const Camera& camera, const FrameView& frame) {
    detail::require_for_render(frame.width == camera.width && frame.height == camera.height,
                               "a frame of the camera's size");
  }

  B backend_;
  Sort sort_;
  ProjectScratch<B> project_scratch_;
  Splats<B> splats_;
  Footprints<B, Bounds> footprints_;
  Colours<B> colours_;
  typename Sort::template Scratch<B> sort_scratch_;
  TileLists<B> lists_;
  typename B::template Buffer<SquareCounts> square_counts_;
  ViewStorage<B> view_storage_, recorded_storage_;  ///< of `render_into` and of `record`
  struct {
    typename B::template Buffer<float> colour, alpha, depth;
  } frame_;                        ///< of `render_resident`, a frame behind the other
  std::vector<FrameView> frames_;  ///< in it
  std::vector<View> views_;        ///< of `render_resident` and `render`
  std::array<typename B::TimePoint, 4> points_{};
  bool counted_ = false, timed_ = false;
  std::size_t gaussians_ = 0;
  FrameReport report_;       ///< of the last frame that was not recorded
  TileChoice tiles_;         ///< that learnt from it
  Capacity capacity_{1, 1};  ///< of a device's frames; grows with them
  Views recorded_;           ///< in `recorded_storage_`
  std::optional<FrameRoom> reserved_;
};

}  // namespace swiftgs
