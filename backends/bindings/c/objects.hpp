// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/c/camera.h>
#include <swiftgs/c/renderer.h>
#include <swiftgs/c/scene.h>
#include <swiftgs/c/view.h>
#include <swiftgs/camera.hpp>
#include <swiftgs/conventions.hpp>
#include <swiftgs/frame.hpp>
#include <swiftgs/lens/view.hpp>
#include <swiftgs/scene.hpp>

#include "device.hpp"
#include "error.hpp"

namespace swiftgs::c {

dvec3 to_vector(const double (&v)[3]);

/// Throws as `read_struct`. The camera itself is not validated.
Camera to_camera(const swiftgs_camera* given);

void write_camera(swiftgs_camera* given, const Camera& camera);

}  // namespace swiftgs::c

struct swiftgs_scene {
  std::shared_ptr<const swiftgs::Scene> scene;
  std::string format{};
  std::uint64_t stored = 0, dropped = 0;
  std::optional<swiftgs::Camera> camera{};
};

namespace swiftgs::c {

/// Copies the arrays of a caller. Throws `InvalidArgument`, and as `require_device` and `copy_memory`.
Scene to_scene(const swiftgs_gaussians* given);

template <class T>
Plane<T> to_plane(const swiftgs_plane& from) {
  return {static_cast<T*>(from.data), std::ptrdiff_t(from.pitch)};
}

/// Numbers of `swiftgs_view::format`.
inline constexpr int format_count = 5;

/// Sets the planes of `frame` to those of `from`, a struct of the C interface.
template <class From>
void set_planes(FrameView& frame, const From& from) {
  frame.feature_channels = from.feature_channels;
  for_each_plane(
      []<class T>(std::size_t, Plane<T>& to, const swiftgs_plane& plane) { to = to_plane<T>(plane); }, frame,
      from);
}

/// Zeros of `from` are the defaults. A float opacity of 2^-29 or more comes back with its bits. Throws
/// `InvalidArgument`.
Placement to_placement(const swiftgs_placement& from);

/// Puts the views of `frame` in place of those in `views`. Throws `InvalidArgument`.
void read_views(const swiftgs_frame& frame, std::vector<View>& views);

/// Where renderers draw.
enum class DrawsIn { host, cuda, vulkan };

/// By the renderer's name.
inline DrawsIn where_draws(std::string_view name) {
  return name.starts_with("cuda/")     ? DrawsIn::cuda
         : name.starts_with("vulkan/") ? DrawsIn::vulkan
                                       : DrawsIn::host;
}

}  // namespace swiftgs::c

struct swiftgs_renderer {
  std::string name, device_name;
  swiftgs::c::DrawsIn draws_in{};
  std::unique_ptr<swiftgs::AnyRenderer> renderer;
  std::shared_ptr<const void> shown{}, recorded{};        ///< cuts in `renderer`, whose pages frames read
  std::unique_ptr<swiftgs::c::HostFrames> host_frames{};  ///< null: the backend reaches the host's memory
  void* stream = nullptr;                                 ///< of a device
  swiftgs::HarmonicsKept harmonics{};                     ///< of scenes that are uploaded
  std::vector<swiftgs::View> views{};                     ///< of one call; their memory is kept
  mutable std::recursive_mutex turn{};  ///< of calls; a memory hook may ask the renderer that called it
};

namespace swiftgs::c {

/// A renderer while it is the turn of this call.
class Turn {
 public:
  explicit Turn(const swiftgs_renderer& renderer) : lock_(renderer.turn), renderer_(*renderer.renderer) {}
  AnyRenderer* operator->() const { return &renderer_; }
  AnyRenderer& operator*() const { return renderer_; }

 private:
  std::unique_lock<std::recursive_mutex> lock_;
  AnyRenderer& renderer_;
};

inline Turn of(const swiftgs_renderer* renderer) {
  require_pointer(renderer, "renderer");
  return Turn(*renderer);
}

/// Throws `Unavailable` where the planes of `call` would lie in memory that C does not reach.
inline void require_reachable(const char* call, const swiftgs_renderer& renderer) {
  if (renderer.draws_in == DrawsIn::vulkan)
    throw Unavailable(std::string(call) + ": renderer '" + renderer.name +
                      "' draws in memory of Vulkan, expected swiftgs_renderer_render");
}

static_assert(int(SplatOrder::depth) == SWIFTGS_ORDER_DEPTH &&
              int(SplatOrder::distance) == SWIFTGS_ORDER_DISTANCE &&
              int(ColourSpace::srgb) == SWIFTGS_COLOURS_SRGB &&
              int(ColourSpace::linear) == SWIFTGS_COLOURS_LINEAR &&
              int(RenderingModel::Kernel::ellipsoid) == SWIFTGS_KERNEL_ELLIPSOID &&
              int(RenderingModel::Kernel::disk) == SWIFTGS_KERNEL_DISK);

/// Sets the members of a struct that tell of a scene's model.
template <class Struct>
void set_model(Struct& to, const RenderingModel& from) {
  to.antialiased = from.antialiased, to.order = int(from.order), to.colours = int(from.colours);
  to.kernel = int(from.kernel), to.blur = from.blur;
}

/// The same for Gaussians in arrays, where a blur of 0 stands for the usual one and a negative one for none.
inline void set_model(swiftgs_gaussians& to, const RenderingModel& from) {
  set_model<swiftgs_gaussians>(to, from);
  if (from.blur == 0) to.blur = -1;
}

/// The model that `set_model` writes to Gaussians in arrays.
inline RenderingModel model_of(const swiftgs_gaussians& from) {
  require_choice(from.order, 2, "swiftgs_gaussians: order");
  require_choice(from.colours, 2, "swiftgs_gaussians: colours");
  require_choice(from.kernel, 2, "swiftgs_gaussians: kernel");
  RenderingModel model;
  model.antialiased = from.antialiased != 0;
  if (from.blur != 0) model.blur = from.blur < 0 ? 0.0f : from.blur;
  model.order = SplatOrder(from.order), model.colours = ColourSpace(from.colours);
  model.kernel = RenderingModel::Kernel(from.kernel);
  return model;
}

}  // namespace swiftgs::c
