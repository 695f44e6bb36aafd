// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <swiftgs/api.hpp>
#include <swiftgs/bound_renderer.hpp>
#include <swiftgs/scene_arrays.hpp>
#include <swiftgs/sort/adaptive.hpp>
#include <swiftgs/type_list.hpp>

namespace swiftgs {

/// A renderer whose policies are chosen at run time.
class SWIFTGS_API AnyRenderer {
 public:
  virtual ~AnyRenderer() = default;

  /// BACKEND/SORT/RASTER/BOUNDS, as in the table of renderers.
  virtual std::string_view name() const = 0;

  /// The backend's `device_name`.
  virtual std::string device_name() const = 0;

  /// Uploads `scene` for the frames that follow; host backends share it. A graph of frames that were recorded
  /// before reads the scene of then: destroy the graph first, unless another renderer shares that scene.
  virtual void set_scene(std::shared_ptr<const Scene> scene) = 0;

  /// As above, of arrays that the backend reaches: those of a device go to its renderers within the device,
  /// in stream order. It waits only if memory has to grow: it reuses memory of the last scene, unless that
  /// was ever shared. A device does not draw Gaussians with a NaN or an infinity, since no pass checks them;
  /// hosts refuse them. Throws `std::invalid_argument` as `validate`. After any other exception a device
  /// renderer has no scene, and a host renderer keeps the last one.
  virtual void set_scene(const SceneArrays& arrays) = 0;

  /// Shares the scene that `other` has uploaded, without another copy. Returns false, and changes nothing, if
  /// `other` has no scene or another backend. A scene of `SceneArrays` is ready in the stream order of
  /// `other`: another stream must wait for that before it draws the scene.
  virtual bool share_scene(const AnyRenderer& other) = 0;

  /// As `Renderer::render`. Throws `std::logic_error` before a scene is set.
  virtual void render(Span<const Camera> cameras, const RenderSettings& settings, Span<Frame> frames) = 0;
  void render(const Camera& camera, const RenderSettings& settings, Frame& frame) {
    render(Span<const Camera>{&camera, 1}, settings, Span<Frame>{&frame, 1});
  }

  /// Renders a frame a camera that stays in the backend's memory until the next call, for a program that
  /// shows or composes it there. The frames are finished when it returns. Throws as `render`.
  virtual Span<const FrameView> render_resident(Span<const Camera> cameras,
                                                const RenderSettings& settings) = 0;
  FrameView render_resident(const Camera& camera, const RenderSettings& settings) {
    const Span<const FrameView> frames = render_resident(Span<const Camera>{&camera, 1}, settings);
    return frames.size == 0 ? FrameView{} : frames[0];
  }

  /// As `Renderer::render_into`, with all that a `View` may ask for. Throws as `render`.
  virtual void render_into(Span<const View> views, Measures measures = {}) = 0;

  /// As `Renderer::reserve`, `set_views` and `record`, of the scene that was set. Throws as `render`.
  virtual void reserve(Span<const View> views, Capacity capacity = {}) = 0;
  virtual void set_views(Span<const View> views) = 0;
  virtual void record(FrameReport* report) = 0;

  /// Returns when all work submitted so far is done.
  virtual void wait() = 0;

  /// As `Renderer::pick`.
  virtual std::vector<PickedPixel> pick(const PickRectangle& rectangle) = 0;
  PickedPixel pick(int x, int y, std::size_t view = 0) { return pick({.x = x, .y = y, .view = view})[0]; }

  /// As `Renderer::times`. @units{milliseconds}
  virtual StageTimes times() = 0;

  /// As `Renderer::statistics`.
  virtual Statistics statistics() const = 0;

  /// As `Renderer::memory`.
  virtual StageMemory memory() const = 0;

  /// As `Renderer::trim`. The scene stays.
  virtual void trim() = 0;

  /// Hands measurements of the scene's sort, on this device and with these bounds, to `AdaptiveSort::use`.
  /// Other sorts ignore them.
  virtual void use_calibrations(std::vector<SortCalibration> saved) = 0;

  /// `AdaptiveSort::calibration`; no value for other sorts.
  virtual std::optional<SortCalibration> calibration() const = 0;

  /// Memory of the backend's device; no value for a backend that works in the host's memory.
  virtual std::optional<MemoryUse> device_memory() const = 0;
};

/// One row of the table of renderers.
struct RendererEntry {
  std::string name;        ///< BACKEND/SORT/RASTER/BOUNDS
  bool usable = false;     ///< whether it can run on this machine
  bool on_device = false;  ///< whether it draws in the memory of a device
  std::function<std::unique_ptr<AnyRenderer>(const BackendOptions&)> make_with;

  std::unique_ptr<AnyRenderer> make(const BackendOptions& options = {}) const { return make_with(options); }
};

/// `AnyRenderer` on backend `B`: a `BoundRenderer` with its name and scene.
template <class B>
class SWIFTGS_API AnyRendererOn final : public AnyRenderer {
 public:
  /// `adaptive` is the sort of `policies`, if it is adaptive.
  AnyRendererOn(std::string name, const BackendOptions& options, StagePolicies<B> policies,
                AdaptiveSort* adaptive)
      : name_(std::move(name)),
        renderer_(make_backend(std::type_identity<B>(), options), std::move(policies)),
        adaptive_(adaptive) {}

  std::string_view name() const override { return name_; }
  void set_scene(std::shared_ptr<const Scene> scene) override {
    scene_.emplace(renderer_.backend().upload(std::move(scene)));
  }
  void set_scene(const SceneArrays& arrays) override {
    scene_.emplace(renderer_.backend().upload(arrays, scene_));
  }
  bool share_scene(const AnyRenderer& other) override {
    const auto* like = dynamic_cast<const AnyRendererOn*>(&other);
    if (!like || !like->scene_) return false;
    scene_ = like->scene_;
    return true;
  }
  void render(Span<const Camera> cameras, const RenderSettings& settings, Span<Frame> frames) override {
    renderer_.render(scene(), cameras, settings, frames);
  }
  Span<const FrameView> render_resident(Span<const Camera> cameras, const RenderSettings& settings) override {
    const Span<const FrameView> frames = renderer_.render_resident(scene().view(), cameras, settings);
    renderer_.backend().wait();
    return frames;
  }
  void render_into(Span<const View> views, Measures measures) override {
    renderer_.render_into(scene().view(), views, measures);
  }
  void reserve(Span<const View> views, Capacity capacity) override {
    renderer_.reserve(scene().view(), views, capacity);
  }
  void set_views(Span<const View> views) override { renderer_.set_views(views); }
  void record(FrameReport* report) override { renderer_.record(scene().view(), report); }
  void wait() override { renderer_.backend().wait(); }
  std::vector<PickedPixel> pick(const PickRectangle& rectangle) override { return renderer_.pick(rectangle); }
  StageTimes times() override { return renderer_.times(); }
  Statistics statistics() const override { return renderer_.statistics(); }
  StageMemory memory() const override { return renderer_.memory(); }
  void trim() override { renderer_.trim(); }
  std::string device_name() const override { return renderer_.backend().device_name(); }
  void use_calibrations(std::vector<SortCalibration> saved) override {
    if (adaptive_) adaptive_->use(std::move(saved));
  }
  std::optional<SortCalibration> calibration() const override {
    return adaptive_ ? adaptive_->calibration() : std::nullopt;
  }
  std::optional<MemoryUse> device_memory() const override {
    if constexpr (B::reaches_host_memory)
      return std::nullopt;
    else
      return B::memory_use();
  }

 private:
  const typename B::SceneOn& scene() const {
    if (!scene_) throw std::logic_error("render: expected a scene before the first frame");
    return *scene_;
  }

  std::string name_;
  BoundRenderer<B> renderer_;
  AdaptiveSort* adaptive_;                      ///< in `renderer_`
  std::optional<typename B::SceneOn> scene_{};  ///< copies share the memory
};

namespace detail {
/// The sort stage of a new renderer.
template <class B>
struct MadeSort {
  std::unique_ptr<SortStage<B>> stage;
  AdaptiveSort* adaptive = nullptr;  ///< the sort, if it is adaptive

  template <class Sort, class Bounds>
  static MadeSort make() {
    auto stage = std::make_unique<SortStageOf<B, Sort, Bounds>>();
    AdaptiveSort* adaptive = nullptr;
    if constexpr (std::is_base_of_v<AdaptiveSort, Sort>) adaptive = &stage->sort;
    return {std::move(stage), adaptive};
  }
};
}  // namespace detail

/// Appends every combination of backend `B` with the given sorts, rasterizers and bounds to `table`.
/// backends/table.cpp holds the library's lists. A policy on a device also needs code that its compiler
/// makes.
template <class B, class... Sorts, class... Rasters, class... Bounds>
void append_renderers(std::vector<RendererEntry>& table, TypeList<Sorts...>, TypeList<Rasters...>,
                      TypeList<Bounds...>) {
  using MakeSort = detail::MadeSort<B> (*)();
  const std::vector<BoundsStages<B>> all_bounds{BoundsStages<B>::template of<Bounds>()...};
  const std::vector<RasterStage<B>> all_rasters{RasterStage<B>::template of<Rasters>()...};
  const auto append = [&](std::string_view sort, const std::vector<MakeSort>& within) {
    for (const RasterStage<B>& raster : all_rasters)
      for (std::size_t k = 0; k < all_bounds.size(); ++k) {
        const BoundsStages<B>& bounds = all_bounds[k];
        std::string name{B::name};
        for (const std::string_view word : {sort, raster.name, bounds.name}) name.append("/").append(word);
        const auto make = [=, make_sort = within[k]](const BackendOptions& options) {
          detail::MadeSort<B> made = make_sort();
          return std::unique_ptr<AnyRenderer>(std::make_unique<AnyRendererOn<B>>(
              name, options, StagePolicies<B>{bounds, std::move(made.stage), raster}, made.adaptive));
        };
        table.push_back({name, B::usable(), !B::reaches_host_memory, make});
      }
  };
  const auto append_sort = [&]<class Sort>() {
    append(Sort::name, {&detail::MadeSort<B>::template make<Sort, Bounds>...});
  };
  (append_sort.template operator()<Sorts>(), ...);
}

/// Every renderer of this build, whether or not it can run here. Defined in the library that joins the
/// backends.
SWIFTGS_API const std::vector<RendererEntry>& renderers();

/// The renderer called `name`; or where `name` is a backend alone, its usual one; or where it is empty, that
/// of the quickest backend that can run here. Throws `std::invalid_argument` with the valid words for any
/// other name.
SWIFTGS_API const RendererEntry& find_renderer(std::string_view name = {});

/// Makes the renderer called `name`. Throws `std::invalid_argument` with the valid words if the name is not
/// known, and `std::runtime_error` if the renderer cannot run here.
SWIFTGS_API std::unique_ptr<AnyRenderer> make_renderer(std::string_view name,
                                                       const BackendOptions& options = {});

}  // namespace swiftgs
