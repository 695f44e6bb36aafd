// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <swiftgs/camera.hpp>
#include <swiftgs/drivers/pick.hpp>
#include <swiftgs/drivers/render_settings.hpp>
#include <swiftgs/drivers/statistics.hpp>
#include <swiftgs/frame.hpp>
#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/backend.hpp>
#include <swiftgs/frame/harmonics.hpp>
#include <swiftgs/frame/placed_scene.hpp>
#include <swiftgs/frame/placing.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/frame/stored_scenes.hpp>
#include <swiftgs/frame/views.hpp>
#include <swiftgs/memory/scene_arrays.hpp>
#include <swiftgs/scene.hpp>

namespace swiftgs {

/// How a frame shows one of a renderer's scenes, or a range of its Gaussians, as `PlacedScene`.
struct Placement {
  static constexpr std::size_t all = std::size_t(-1);

  std::size_t scene = 0;  ///< number of the scene, as `add_scene` returns it
  Similarity world_from_scene{};
  float opacity = 1;
  Clip clip{};
  Tint tint{};
  /// Number of the first Gaussian that shows. Views skip chunks of the range if it is a multiple of
  /// `chunk_size`; others are drawn too, and take longer.
  std::size_t first = 0;
  std::size_t count = all;  ///< Gaussians that show; `all` from `first` on
};

/// A scene in the memory of a backend that need not be named. Copies are one scene.
class UploadedScene {
 public:
  template <class SceneOn>
  explicit UploadedScene(SceneOn scene)
      : view_(scene.view()), kept_(std::make_shared<const SceneOn>(std::move(scene))) {}
  SceneView view() const { return view_; }

 private:
  SceneView view_;
  std::shared_ptr<const void> kept_;
};

/// A renderer whose type does not name its policies: one of `make_renderer`, or any `Renderer`. It keeps
/// scenes by number and draws the placed ones.
///
/// It keeps the memory of its stages, so a frame no larger than an earlier one allocates nothing. All memory
/// is from the hook of its backend. Use one renderer from one thread at a time; different renderers are safe.
class SWIFTGS_API AnyRenderer {
 public:
  virtual ~AnyRenderer() = default;

  /// BACKEND/SORT/RASTER/BOUNDS, as in the table of renderers.
  virtual std::string_view name() const = 0;

  /// The backend's `device_name`.
  virtual std::string device_name() const = 0;

  /// Uploads `scene` for the frames that follow, in place of all scenes and placements before; host backends
  /// share it. A graph of frames that were recorded before reads the scene of then: destroy the graph first,
  /// unless another renderer shares that scene.
  virtual void set_scene(std::shared_ptr<const Scene> scene,
                         HarmonicsKept kept = HarmonicsKept::smallest) = 0;

  /// Sets a scene of arrays that the backend reaches: a device copies its own arrays within the device, in
  /// stream order. Reuses the memory of the last scene, unless that was ever shared, and waits only if memory
  /// has to grow. A device does not draw Gaussians with a NaN or an infinity, since no pass checks them;
  /// hosts refuse them. Throws `InvalidArgument` as `validate`. After any other exception a device
  /// renderer has no scene, and a host renderer keeps the last one.
  virtual void set_scene(const SceneArrays& arrays) = 0;

  /// Sets a scene of arrays that frames read without a copy or a check of numbers, in memory that the backend
  /// reaches. The arrays must outlive all frames until another scene is set, and may change between frames.
  /// Throws as `view(SceneArrays)`.
  virtual void borrow_scene(const SceneArrays& arrays) = 0;

  /// Uploads one more scene, and returns its number: 0, 1 and so on. Frames show it too, where it stands by
  /// itself, until the next `place`. Throws as `set_scene`.
  virtual std::size_t add_scene(std::shared_ptr<const Scene> scene,
                                HarmonicsKept kept = HarmonicsKept::smallest) = 0;

  /// How a scene's harmonics are kept, as `name_of` says it. Throws `InvalidArgument` for an unknown
  /// scene.
  virtual const char* harmonics(std::size_t scene) const = 0;

  /// Replaces Gaussians of a scene from number `first` on by those of `arrays`, which the backend reaches;
  /// arrays that are null stay as they are. Renderers that share the scene show the update too, as do all
  /// later and recorded frames. On a device in stream order, without waiting; the streams of others must wait
  /// for it. On hosts no frame of the scene may be under way, the program's own `Scene` stays as it is, and
  /// numbers that are not finite are refused; see `set_scene`. Throws `InvalidArgument`, and changes
  /// nothing, for an unknown scene, and as `validate_update`.
  virtual void update_scene(std::size_t scene, std::size_t first, const SceneArrays& arrays) = 0;

  /// Sets the placed scenes that frames show: any of the renderer's scenes, any number of times, each whole
  /// or in part. Throws `InvalidArgument`, and changes nothing, for no placement, an unknown scene, a
  /// range that the scene does not have, and as `validate` of a placed scene.
  virtual void place(Span<const Placement> placements) = 0;

  /// Uploads a scene that the caller keeps, apart from those with numbers, for `show`. Throws as `set_scene`.
  virtual UploadedScene upload(Scene scene, HarmonicsKept kept = HarmonicsKept::smallest) = 0;

  /// Shows placed scenes of the caller, such as of `upload`, in place of those of `place`, until another call
  /// sets, adds, shares or places scenes. Their memory is the backend's, and stays until no frame shows them.
  /// Throws `InvalidArgument`, and changes nothing, as `validate` of a placed scene.
  virtual void show(Span<const PlacedScene> scenes) = 0;

  /// Shares the scenes that `other` has uploaded, without copies, and their placements, but none of `show`.
  /// Returns false, and changes nothing, if `other` has no scene or another backend. A scene of `SceneArrays`
  /// is ready in the stream order of `other`: another stream must wait for that before it draws the scene.
  virtual bool share_scene(const AnyRenderer& other) = 0;

  /// Renders a frame a camera on the host; complete when it returns. Throws `OrderError` before a scene is
  /// set, and as `render_into`.
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

  /// As `FrameRenderer::render_into`.
  virtual void render_into(Span<const View> views, Measures measures = {}) = 0;

  /// As `RecordedFrames::reserve`, `set_views` and `record`, of what is placed at the time of `reserve`,
  /// which throws `OrderError` before a scene is set. A scene alone may be another one at each `record`.
  virtual void reserve(Span<const View> views, Capacity capacity = {}) = 0;
  virtual void set_views(Span<const View> views) = 0;
  virtual void record(FrameReport* report) = 0;
  /// Makes recorded work show the current placing when it runs again. Throws as `RecordedFrames::set_scenes`.
  virtual void set_recorded_scenes() = 0;
  /// As `RecordedFrames::stored_scenes` and `refused_scenes`.
  virtual Span<StoredScene> recorded_scenes() = 0;
  virtual std::vector<std::size_t> refused_scenes() const = 0;

  /// Returns when all work submitted so far is done.
  virtual void wait() = 0;

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
  virtual std::vector<PickedPixel> pick(const PickRectangle& rectangle) = 0;
  /// At one pixel, from the top left of the view's frame.
  PickedPixel pick(int x, int y, std::size_t view = 0) { return pick({.x = x, .y = y, .view = view})[0]; }

  /// As `FrameMeasures::times`. @units{milliseconds}
  virtual StageTimes times() = 0;

  /// As `FrameMeasures::statistics`.
  virtual Statistics statistics() const = 0;
  /// As `visible_by_scene` of a `FrameRenderer`: a number a placement.
  virtual std::vector<std::size_t> visible_by_scene() const = 0;

  /// Bytes that the buffers of each stage take in the backend's memory. Buffers grow with the largest frame
  /// so far, and are empty after `trim`.
  virtual StageMemory memory() const = 0;

  /// Gives back all memory that the renderer and its backend keep, uploaded scenes excluded, after waiting
  /// for all work submitted so far. The next frame allocates again. Forgets the set views
  /// and the reservation, so `record` is refused until the next `reserve`. Also gone: the frame of
  /// `render_resident`, the last frame's splats and tile lists, and counts of `statistics`.
  virtual void trim() = 0;

  /// False while an adaptive sort still measures frames of the scene at this size.
  virtual bool sort_decided() = 0;

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

/// Every renderer of this build, whether or not it can run here. Defined in the library that joins the
/// backends.
SWIFTGS_API const std::vector<RendererEntry>& renderers();

/// The renderer called `name`; or where `name` is a backend alone, its usual one; or where it is empty, that
/// of the quickest backend that can run here. Throws `InvalidArgument` with the valid words for any
/// other name.
SWIFTGS_API const RendererEntry& find_renderer(std::string_view name = {});

/// Makes the renderer called `name`. Throws `InvalidArgument` with the valid words if the name is not
/// known, and `Unavailable` if the renderer cannot run here.
SWIFTGS_API std::unique_ptr<AnyRenderer> make_renderer(std::string_view name,
                                                       const BackendOptions& options = {});

}  // namespace swiftgs
