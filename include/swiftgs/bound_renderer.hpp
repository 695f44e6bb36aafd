// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include <swiftgs/backend.hpp>
#include <swiftgs/camera.hpp>
#include <swiftgs/count.hpp>
#include <swiftgs/frame.hpp>
#include <swiftgs/frame_renderer.hpp>
#include <swiftgs/measure.hpp>
#include <swiftgs/message.hpp>
#include <swiftgs/pick_stage.hpp>
#include <swiftgs/placed_scene.hpp>
#include <swiftgs/recorded_frames.hpp>
#include <swiftgs/render_settings.hpp>
#include <swiftgs/resident_frames.hpp>
#include <swiftgs/stages.hpp>
#include <swiftgs/statistics.hpp>
#include <swiftgs/view.hpp>

namespace swiftgs {

namespace detail {
struct DoNothing {
  void operator()() const {}
};
}  // namespace detail

/// A renderer on backend `B` whose other policies are bound to it at run time, with all drivers: what all
/// `Renderer`s on `B` share.
///
/// It keeps the memory of its stages, so a frame no larger than an earlier one allocates nothing. All of it
/// is from the hook of its backend. It is not safe to use from two threads at once; two renderers are.
template <class B>
class BoundRenderer {
 public:
  BoundRenderer(B backend, const StageTable<B>& table, std::unique_ptr<SortStage<B>> sort)
      : renderer_(std::move(backend), table, std::move(sort)) {
    use_memory_of(this->backend(), measures_, recorded_, resident_, picker_);
  }

  B& backend() { return renderer_.backend(); }
  const B& backend() const { return renderer_.backend(); }
  /// For drivers of your own.
  FrameRenderer<B>& frame_renderer() { return renderer_; }
  Stages<B>& stages() { return renderer_.stages(); }

  /// Renders into memory of the caller that the backend can reach. On a device it returns when the frame is
  /// in stream order, not when it is finished. Throws `InvalidArgument` for a camera, scene or frame
  /// that nothing can be rendered with, `CapacityError`, and `DeviceError` on a device.
  void render_into(const PlacedScenes& scenes, const Camera& camera, const RenderSettings& settings,
                   const FrameView& frame) {
    validate(settings);
    detail::require_for_render(frame.width == camera.width && frame.height == camera.height,
                               "a frame of the camera's size");
    const View view = make_view(camera, settings.conventions, frame, settings.background);
    render_into(scenes, Span{&view, 1}, {settings.count, settings.time});
  }

  /// As `FrameRenderer::render_into`.
  void render_into(const PlacedScenes& scenes, Span<const View> views, Measures measures = {}) {
    measures_.render_into(renderer_, scenes, views, measures);
  }

  /// As of `RecordedFrames`.
  void reserve(const PlacedScenes& scenes, Span<const View> views, Capacity capacity = {}) {
    recorded_.reserve(renderer_, scenes, views, capacity);
  }
  void set_views(Span<const View> views) { recorded_.set_views(backend(), views); }
  void set_scenes(const PlacedScenes& scenes) { recorded_.set_scenes(backend(), scenes); }
  PlacedScene* recorded_scenes() { return recorded_.stored_scenes(); }
  std::vector<std::size_t> refused_scenes() const { return recorded_.refused_scenes(backend()); }
  template <class BeforeRaster = detail::DoNothing>
  requires std::invocable<const BeforeRaster&>
  void record(const SceneView& scene, FrameReport* report, const BeforeRaster& before_raster = {}) {
    recorded_.record(renderer_, scene, report, before_raster);
  }
  template <class BeforeRaster = detail::DoNothing>
  requires std::invocable<const BeforeRaster&>
  void record(FrameReport* report, const BeforeRaster& before_raster = {}) {
    recorded_.record(renderer_, report, before_raster);
  }

  /// Gives back all memory that the renderer and its backend keep, uploaded scenes excluded, after waiting
  /// for all work submitted so far. The next frame takes it again. Views that were set and what was reserved
  /// are forgotten, so `record` is refused until the next `reserve`. Frames of `render_resident`, `splats`,
  /// `lists`, `tiles` and what `statistics` counts on request are gone.
  void trim() {
    renderer_.trim();
    trim_parts(backend(), measures_, recorded_, resident_, picker_);
    views_ = {};
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
  /// Throws `OrderError` if there is no frame: before the first, after `reserve` and `trim`, and after
  /// one that failed once its views were valid; `InvalidArgument` for an unknown view, or a rectangle
  /// that does not lie in its frame; and `DeviceError` on a device.
  std::vector<PickedPixel> pick(const PickRectangle& rectangle) { return picker_.pick(renderer_, rectangle); }
  /// At one pixel, from the top left of the view's frame.
  PickedPixel pick(int x, int y, std::size_t view = 0) { return pick({.x = x, .y = y, .view = view})[0]; }

  /// As of `FrameMeasures`.
  StageTimes times() { return measures_.times(backend()); }
  Statistics statistics() const { return measures_.statistics(renderer_); }
  std::vector<std::size_t> visible_by_scene() const { return swiftgs::visible_by_scene(renderer_); }

  /// Bytes that the buffers of each stage take in the backend's memory. Buffers grow with the largest frame
  /// so far, and are empty after `trim`.
  StageMemory memory() const {
    StageMemory memory = renderer_.memory();
    memory.project += bytes_of(recorded_);
    memory.raster += bytes_of(resident_, measures_, picker_);
    return memory;
  }

  /// Whether coarser tiles than `default_tile_side` change no bit and may save time.
  bool may_gain_by_coarse_tiles() const { return renderer_.may_gain_by_coarse_tiles(); }

  /// The last frame's splats and tile lists, in the backend's memory, until the next frame; and its tiles.
  const Splats<B>& splats() const { return renderer_.stages().splats(); }
  const TileLists<B>& lists() const { return renderer_.stages().lists(); }
  const FrameTiles& tiles() const { return renderer_.stages().tiles(); }

 private:
  FrameRenderer<B> renderer_;
  FrameMeasures<B> measures_;
  RecordedFrames<B> recorded_;
  ResidentFrames<B> resident_;
  Picker<B> picker_;
  std::vector<View> views_;  ///< of `render_resident` and `render`
};

}  // namespace swiftgs
