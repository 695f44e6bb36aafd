// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <swiftgs/api.hpp>
#include <swiftgs/renderer.hpp>
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
  /// in stream order. That waits only where memory has to grow: memory of the scene before is taken again,
  /// unless it was ever shared. On a device Gaussians with a NaN or an infinity are not drawn, since no pass
  /// checks them; hosts refuse them. Throws `std::invalid_argument` as `validate`. After any other exception
  /// a renderer of a device has no scene, and one of a host has that of before.
  virtual void set_scene(const SceneArrays& arrays) = 0;

  /// Shares the scene that `other` has uploaded, without another copy. Returns false, and changes nothing, if
  /// `other` has no scene or another backend. A scene of `SceneArrays` is there in the order of the stream of
  /// `other`: another stream has to wait for that before it draws the scene.
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
  std::string_view name;  ///< BACKEND/SORT/RASTER/BOUNDS
  bool usable = false;    ///< whether it can run on this machine
  std::unique_ptr<AnyRenderer> (*make_with)(const BackendOptions& options) = nullptr;

  std::unique_ptr<AnyRenderer> make(const BackendOptions& options = {}) const { return make_with(options); }
};

/// Common part of the renderers on backend `B`.
template <class B>
class SWIFTGS_API RendererOn : public AnyRenderer {
 public:
  bool share_scene(const AnyRenderer& other) override {
    const auto* like = dynamic_cast<const RendererOn*>(&other);
    if (!like || !like->scene_) return false;
    scene_ = like->scene_;
    return true;
  }
  std::optional<MemoryUse> device_memory() const override {
    if constexpr (B::reaches_host_memory)
      return std::nullopt;
    else
      return B::memory_use();
  }

 protected:
  const typename B::SceneOn& scene() const {
    if (!scene_) throw std::logic_error("render: expected a scene before the first frame");
    return *scene_;
  }
  std::optional<typename B::SceneOn> scene_;  ///< copies share the memory
};

/// `AnyRenderer` of one combination.
template <class R, class B>
class RendererOf final : public RendererOn<B> {
 public:
  explicit RendererOf(const BackendOptions& options = {})
      : renderer_(make_backend(std::type_identity<B>(), options)) {}

  std::string_view name() const override { return R::name; }
  void set_scene(std::shared_ptr<const Scene> scene) override {
    this->scene_.emplace(renderer_.backend().upload(std::move(scene)));
  }
  void set_scene(const SceneArrays& arrays) override {
    this->scene_.emplace(renderer_.backend().upload(arrays, this->scene_));
  }
  void render(Span<const Camera> cameras, const RenderSettings& settings, Span<Frame> frames) override {
    renderer_.render(this->scene(), cameras, settings, frames);
  }
  Span<const FrameView> render_resident(Span<const Camera> cameras, const RenderSettings& settings) override {
    const Span<const FrameView> frames = renderer_.render_resident(this->scene().view(), cameras, settings);
    renderer_.backend().wait();
    return frames;
  }
  void render_into(Span<const View> views, Measures measures) override {
    renderer_.render_into(this->scene().view(), views, measures);
  }
  void reserve(Span<const View> views, Capacity capacity) override {
    renderer_.reserve(this->scene().view(), views, capacity);
  }
  void set_views(Span<const View> views) override { renderer_.set_views(views); }
  void record(FrameReport* report) override { renderer_.record(this->scene().view(), report); }
  void wait() override { renderer_.backend().wait(); }
  StageTimes times() override { return renderer_.times(); }
  Statistics statistics() const override { return renderer_.statistics(); }
  StageMemory memory() const override { return renderer_.memory(); }
  void trim() override { renderer_.trim(); }
  std::string device_name() const override { return renderer_.backend().device_name(); }
  void use_calibrations(std::vector<SortCalibration> saved) override {
    if constexpr (takes_calibrations) renderer_.sort().use(std::move(saved));
  }
  std::optional<SortCalibration> calibration() const override {
    if constexpr (takes_calibrations)
      return renderer_.sort().calibration();
    else
      return std::nullopt;
  }

 private:
  static constexpr bool takes_calibrations = requires(R renderer, std::vector<SortCalibration> saved) {
    renderer.sort().use(std::move(saved));
  };
  R renderer_;
};

/// Appends every combination of `backend` with the given sorts, rasterizers and bounds to `table`.
/// backends/table.cpp holds the library's lists. A policy on a device also needs code that its compiler
/// makes.
template <class B, class... Sorts, class... Rasters, class... Bounds>
void append_renderers(std::vector<RendererEntry>& table, TypeList<Sorts...>, TypeList<Rasters...>,
                      TypeList<Bounds...>) {
  const auto add = [&]<class S, class R, class Bd>() {
    using Combination = Renderer<B, S, R, Bd>;
    table.push_back(
        {Combination::name, B::usable(), [](const BackendOptions& options) -> std::unique_ptr<AnyRenderer> {
           return std::make_unique<RendererOf<Combination, B>>(options);
         }});
  };
  const auto each_bounds = [&]<class S, class R>() { (add.template operator()<S, R, Bounds>(), ...); };
  const auto each_raster = [&]<class S>() { (each_bounds.template operator()<S, Rasters>(), ...); };
  (each_raster.template operator()<Sorts>(), ...);
}

/// Every renderer of this build, whether or not it can run here. Defined in the library that joins the
/// backends.
SWIFTGS_API const std::vector<RendererEntry>& renderers();

/// Makes the renderer called `name`. Throws `std::invalid_argument` with the valid words if the name is not
/// known, and `std::runtime_error` if the renderer cannot run here.
SWIFTGS_API std::unique_ptr<AnyRenderer> make_renderer(std::string_view name,
                                                       const BackendOptions& options = {});

}  // namespace swiftgs
