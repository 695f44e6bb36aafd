// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/camera.hpp>
#include <swiftgs/drivers/kept_scenes.hpp>
#include <swiftgs/drivers/measure.hpp>
#include <swiftgs/drivers/pick.hpp>
#include <swiftgs/drivers/picker.hpp>
#include <swiftgs/drivers/recorded_frames.hpp>
#include <swiftgs/drivers/render_settings.hpp>
#include <swiftgs/drivers/resident_frames.hpp>
#include <swiftgs/drivers/statistics.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/frame.hpp>
#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/backend.hpp>
#include <swiftgs/frame/frame_renderer.hpp>
#include <swiftgs/frame/harmonics.hpp>
#include <swiftgs/frame/placed_scene.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/frame/stages.hpp>
#include <swiftgs/frame/stored_scenes.hpp>
#include <swiftgs/lens/view.hpp>
#include <swiftgs/memory/scene_arrays.hpp>
#include <swiftgs/scene.hpp>

namespace swiftgs {

namespace detail {
struct DoNothing {
  void operator()() const {}
};
}  // namespace detail

/// The base of all `Renderer`s on backend `B`: its other policies are bound at run time, and it has all
/// drivers. Draws scenes that it keeps, and scenes that its caller keeps.
///
/// Functions that take long to compile are defined below the class: inside it they would be inline, and a
/// source that finds an instance in a library would compile them all the same, for the table of virtual
/// functions.
template <class B>
class SWIFTGS_API BoundRenderer : public AnyRenderer {
 public:
  /// `name` is BACKEND/SORT/RASTER/BOUNDS.
  BoundRenderer(std::string name, B backend, const StageTable<B>& table, std::unique_ptr<SortStage<B>> sort);

  B& backend() { return renderer_.backend(); }
  const B& backend() const { return renderer_.backend(); }
  /// For drivers of your own.
  FrameRenderer<B>& frame_renderer() { return renderer_; }
  Stages<B>& stages() { return renderer_.stages(); }

  std::string_view name() const override { return name_; }
  std::string device_name() const override { return backend().device_name(); }

  void set_scene(std::shared_ptr<const Scene> scene, HarmonicsKept kept = HarmonicsKept::smallest) override;
  void set_scene(const SceneArrays& arrays) override;
  void borrow_scene(const SceneArrays& arrays) override;
  std::size_t add_scene(std::shared_ptr<const Scene> scene,
                        HarmonicsKept kept = HarmonicsKept::smallest) override;
  const char* harmonics(std::size_t scene) const override { return kept_.harmonics(scene); }
  void update_scene(std::size_t scene, std::size_t first, const SceneArrays& arrays) override;
  void place(Span<const Placement> placements) override;
  UploadedScene upload(Scene scene, HarmonicsKept kept = HarmonicsKept::smallest) override;
  void show(Span<const PlacedScene> scenes) override;
  bool share_scene(const AnyRenderer& other) override;

  using AnyRenderer::pick, AnyRenderer::render, AnyRenderer::render_resident;
  void render(Span<const Camera> cameras, const RenderSettings& settings, Span<Frame> frames) override;
  Span<const FrameView> render_resident(Span<const Camera> cameras, const RenderSettings& settings) override;
  void render_into(Span<const View> views, Measures measures = {}) override;
  void reserve(Span<const View> views, Capacity capacity = {}) override;
  void set_views(Span<const View> views) override;
  void record(FrameReport* report) override;
  void set_recorded_scenes() override;
  Span<StoredScene> recorded_scenes() override;
  std::vector<std::size_t> refused_scenes() const override { return recorded_.refused_scenes(backend()); }
  void wait() override { backend().wait(); }

  std::vector<PickedPixel> pick(const PickRectangle& rectangle) override;
  StageTimes times() override { return measures_.times(backend()); }
  Statistics statistics() const override { return measures_.statistics(renderer_); }
  std::vector<std::size_t> visible_by_scene() const override { return swiftgs::visible_by_scene(renderer_); }
  StageMemory memory() const override;
  void trim() override;
  bool sort_decided() override { return stages().sort().decided(); }
  std::optional<MemoryUse> device_memory() const override {
    if constexpr (requires { B::memory_use(); })
      return B::memory_use();
    else
      return std::nullopt;
  }

  // The functions above, of `scenes` that the caller keeps.

  void render(const PlacedScenes& scenes, Span<const Camera> cameras, const RenderSettings& settings,
              Span<Frame> frames);
  void render(const PlacedScenes& scenes, const Camera& camera, const RenderSettings& settings,
              Frame& frame) {
    render(scenes, {&camera, 1}, settings, {&frame, 1});
  }
  Frame render(const PlacedScenes& scenes, const Camera& camera, const RenderSettings& settings = {}) {
    Frame frame;
    render(scenes, camera, settings, frame);
    return frame;
  }

  /// Does not wait for the frames.
  Span<const FrameView> render_resident(const PlacedScenes& scenes, Span<const Camera> cameras,
                                        const RenderSettings& settings);
  FrameView render_resident(const PlacedScenes& scenes, const Camera& camera,
                            const RenderSettings& settings) {
    return render_resident(scenes, {&camera, 1}, settings)[0];
  }

  void render_into(const PlacedScenes& scenes, Span<const View> views, Measures measures = {});
  /// One view, as `make_view` makes it.
  void render_into(const PlacedScenes& scenes, const Camera& camera, const RenderSettings& settings,
                   const FrameView& frame);

  void reserve(const PlacedScenes& scenes, Span<const View> views, Capacity capacity = {});
  void set_scenes(const PlacedScenes& scenes);
  template <class BeforeRaster = detail::DoNothing>
  requires std::invocable<const BeforeRaster&>
  void record(const SceneView& scene, FrameReport* report, const BeforeRaster& before_raster = {}) {
    recorded_.record(renderer_, scene, report, before_raster);
  }
  template <class BeforeRaster>
  requires std::invocable<const BeforeRaster&>
  void record(FrameReport* report, const BeforeRaster& before_raster) {
    if (records_kept_ && !kept_.records_placed())
      return record(kept_.recorded_alone(), report, before_raster);
    if constexpr (B::reaches_host_memory)
      if (records_kept_) kept_.update_recorded(recorded_.stored_scenes().data);
    recorded_.record(renderer_, report, before_raster);
  }

  /// Whether coarser tiles than `default_tile_side` change no bit and may save time.
  bool may_gain_by_coarse_tiles() const { return renderer_.may_gain_by_coarse_tiles(); }

  /// The last frame's splats and tile lists, in the backend's memory, until the next frame; and its tiles.
  const Splats<B>& splats() const { return renderer_.stages().splats(); }
  const TileLists<B>& lists() const { return renderer_.stages().lists(); }
  const FrameTiles& tiles() const { return renderer_.stages().tiles(); }

 private:
  std::string name_;
  FrameRenderer<B> renderer_;
  FrameMeasures<B> measures_;
  RecordedFrames<B> recorded_;
  ResidentFrames<B> resident_;
  Picker<B> picker_;
  KeptScenes<B> kept_;
  bool records_kept_ = false;  ///< `recorded_` has scenes of `kept_`
  std::vector<View> views_;    ///< of `render_resident` and `render`
};

template <class B>
BoundRenderer<B>::BoundRenderer(std::string name, B backend, const StageTable<B>& table,
                                std::unique_ptr<SortStage<B>> sort)
    : name_(std::move(name)), renderer_(std::move(backend), table, std::move(sort)) {
  use_memory_of(this->backend(), measures_, recorded_, resident_, picker_);
}

template <class B>
void BoundRenderer<B>::set_scene(std::shared_ptr<const Scene> scene, HarmonicsKept kept) {
  kept_.set(backend(), std::move(scene), kept);
}
template <class B>
void BoundRenderer<B>::set_scene(const SceneArrays& arrays) {
  kept_.set(backend(), arrays);
}
template <class B>
void BoundRenderer<B>::borrow_scene(const SceneArrays& arrays) {
  kept_.borrow(arrays);
}
template <class B>
std::size_t BoundRenderer<B>::add_scene(std::shared_ptr<const Scene> scene, HarmonicsKept kept) {
  return kept_.add(backend(), std::move(scene), kept);
}
template <class B>
void BoundRenderer<B>::update_scene(std::size_t scene, std::size_t first, const SceneArrays& arrays) {
  kept_.update(backend(), scene, first, arrays);
}
template <class B>
void BoundRenderer<B>::place(Span<const Placement> placements) {
  kept_.place(placements);
}
template <class B>
UploadedScene BoundRenderer<B>::upload(Scene scene, HarmonicsKept kept) {
  return UploadedScene(KeptScenes<B>::upload(backend(), std::move(scene), kept));
}
template <class B>
void BoundRenderer<B>::show(Span<const PlacedScene> scenes) {
  kept_.show(scenes);
}
template <class B>
bool BoundRenderer<B>::share_scene(const AnyRenderer& other) {
  const auto* like = dynamic_cast<const BoundRenderer*>(&other);
  return like && kept_.share(like->kept_);
}

template <class B>
void BoundRenderer<B>::render(Span<const Camera> cameras, const RenderSettings& settings,
                              Span<Frame> frames) {
  render(kept_.scenes(), cameras, settings, frames);
}
template <class B>
void BoundRenderer<B>::render(const PlacedScenes& scenes, Span<const Camera> cameras,
                              const RenderSettings& settings, Span<Frame> frames) {
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

template <class B>
Span<const FrameView> BoundRenderer<B>::render_resident(Span<const Camera> cameras,
                                                        const RenderSettings& settings) {
  const Span<const FrameView> frames = render_resident(kept_.scenes(), cameras, settings);
  wait();
  return frames;
}
template <class B>
Span<const FrameView> BoundRenderer<B>::render_resident(const PlacedScenes& scenes,
                                                        Span<const Camera> cameras,
                                                        const RenderSettings& settings) {
  make_views(cameras, settings, views_);
  require_features(scenes, settings.outputs.features);  // before memory is taken for them
  check_ready(backend());
  const Span<const FrameView> frames = resident_.make(cameras, settings.outputs);
  for (std::size_t i = 0; i < frames.size; ++i) views_[i].frame = frames[i];
  render_into(scenes, {views_.data(), views_.size()}, {settings.count, settings.time});
  return frames;
}

template <class B>
void BoundRenderer<B>::render_into(Span<const View> views, Measures measures) {
  render_into(kept_.scenes(), views, measures);
}
template <class B>
void BoundRenderer<B>::render_into(const PlacedScenes& scenes, Span<const View> views, Measures measures) {
  measures_.render_into(renderer_, scenes, views, measures);
}
template <class B>
void BoundRenderer<B>::render_into(const PlacedScenes& scenes, const Camera& camera,
                                   const RenderSettings& settings, const FrameView& frame) {
  validate(settings);
  detail::require_for_render(frame.width == camera.width && frame.height == camera.height,
                             "a frame of the camera's size");
  const View view = make_view(camera, settings.conventions, frame, settings.background);
  render_into(scenes, Span{&view, 1}, {settings.count, settings.time});
}

template <class B>
void BoundRenderer<B>::reserve(Span<const View> views, Capacity capacity) {
  const PlacedScenes now = kept_.scenes();
  reserve(now, views, capacity);
  kept_.note_recorded(now.is_alone()), records_kept_ = true;
}
template <class B>
void BoundRenderer<B>::reserve(const PlacedScenes& scenes, Span<const View> views, Capacity capacity) {
  records_kept_ = false;
  recorded_.reserve(renderer_, scenes, views, capacity);
}
template <class B>
void BoundRenderer<B>::set_views(Span<const View> views) {
  recorded_.set_views(backend(), views);
}
template <class B>
void BoundRenderer<B>::record(FrameReport* report) {
  record(report, detail::DoNothing());
}
template <class B>
Span<StoredScene> BoundRenderer<B>::recorded_scenes() {
  if (records_kept_ && !kept_.records_placed())
    throw OrderError("recorded_scenes: expected reserve of placed scenes before");
  return recorded_.stored_scenes();
}

template <class B>
void BoundRenderer<B>::set_recorded_scenes() {
  recorded_.set_scenes(backend(), kept_.scenes());
  kept_.note_recorded(false), records_kept_ = true;
}
template <class B>
void BoundRenderer<B>::set_scenes(const PlacedScenes& scenes) {
  recorded_.set_scenes(backend(), scenes);
  records_kept_ = false;
}

template <class B>
std::vector<PickedPixel> BoundRenderer<B>::pick(const PickRectangle& rectangle) {
  if constexpr (requires(B & b, const PickJob& job) { pick_pixels(b, job); })
    return picker_.pick(renderer_, rectangle);
  else
    refuse_missing<B>("pick_pixels");
}
template <class B>
StageMemory BoundRenderer<B>::memory() const {
  StageMemory memory = renderer_.memory();
  memory.project += bytes_of(recorded_);
  memory.raster += bytes_of(resident_, measures_, picker_);
  return memory;
}
template <class B>
void BoundRenderer<B>::trim() {
  renderer_.trim();
  trim_parts(backend(), measures_, recorded_, resident_, picker_);
  views_ = {}, records_kept_ = false;
}

}  // namespace swiftgs
