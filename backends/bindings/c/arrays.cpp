// SPDX-License-Identifier: Apache-2.0

// Gaussians in arrays of the caller.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <swiftgs/memory/copy_arrays.hpp>
#include <swiftgs/memory/scene_arrays.hpp>
#include <swiftgs/serial.hpp>

#include "device.hpp"
#include "error.hpp"
#include "objects.hpp"
#include "structs.hpp"

namespace swiftgs::c {
namespace {

swiftgs_gaussians read_gaussians(const swiftgs_gaussians* given) {
  const swiftgs_gaussians from = read_struct(given, "swiftgs_gaussians");
  require_choice(from.memory, 2, "swiftgs_gaussians: memory");
  constexpr std::uint32_t known =
      SWIFTGS_LOG_SCALES | SWIFTGS_LOGIT_OPACITIES | SWIFTGS_ANY_ROTATIONS | SWIFTGS_PLAIN_COLOURS;
  if (from.raw & ~known) refuse("swiftgs_gaussians: raw is ", from.raw, ", expected a sum of 1, 2, 4 and 8");
  if (from.memory == SWIFTGS_DEVICE) require_device("swiftgs_gaussians: arrays on a device");
  return from;
}

SceneArrays to_arrays(const swiftgs_gaussians& from) {
  const auto array = [](const swiftgs_array& a) { return FloatArray{a.data, std::ptrdiff_t(a.stride)}; };
  return {.count = std::size_t(from.count),
          .means = array(from.means),
          .scales = array(from.scales),
          .rotations = array(from.rotations),
          .opacities = array(from.opacities),
          .sh0 = array(from.sh0),
          .sh_rest = array(from.sh_rest),
          .sh_degree = from.sh_degree,
          .features = array(from.features),
          .feature_channels = from.feature_channels,
          .log_scales = (from.raw & SWIFTGS_LOG_SCALES) != 0,
          .logit_opacities = (from.raw & SWIFTGS_LOGIT_OPACITIES) != 0,
          .any_rotations = (from.raw & SWIFTGS_ANY_ROTATIONS) != 0,
          .plain_colours = (from.raw & SWIFTGS_PLAIN_COLOURS) != 0,
          .model = model_of(from)};
}

/// A scene of arrays on either side. Those of a device are copied as they lie, gaps included.
Scene to_scene(const swiftgs_gaussians& from) {
  SceneArrays arrays = to_arrays(from);
  validate(arrays);
  std::vector<std::vector<float>> fetched;
  const auto fetch = [&](const char*, std::size_t width, FloatArray& array) {
    if (arrays.count == 0 || width == 0) return;
    const std::size_t stride = array.stride != 0 ? std::size_t(array.stride) / sizeof(float) : width;
    auto& floats = fetched.emplace_back((arrays.count - 1) * stride + width);
    copy_memory(floats.data(), array.data, floats.size() * sizeof(float), from.stream);
    array.data = floats.data();
  };
  if (from.memory == SWIFTGS_DEVICE) for_each_array(fetch, arrays);
  Scene scene = to_scene(Serial(), arrays);
  scene.origin = {from.origin[0], from.origin[1], from.origin[2]};
  validate(scene);
  return scene;
}

/// Calls take(arrays) after what `stream` of the arrays has now, and before what it is given later.
template <class F>
void in_stream_order(const swiftgs_renderer& renderer, const swiftgs_gaussians& from, const F& take) {
  const bool on_device = from.memory == SWIFTGS_DEVICE;
  const SceneArrays arrays = to_arrays(from);
  if (on_device) order_streams(from.stream, renderer.stream);
  take(arrays);
  if (on_device) order_streams(renderer.stream, from.stream);
}

bool lie_where_drawn(const swiftgs_renderer& renderer, const swiftgs_gaussians& from) {
  return renderer.draws_in == (from.memory == SWIFTGS_DEVICE ? DrawsIn::cuda : DrawsIn::host);
}

void require_where_drawn(const std::string& call, const swiftgs_renderer& renderer,
                         const swiftgs_gaussians& from) {
  if (lie_where_drawn(renderer, from)) return;
  const bool on_device = from.memory == SWIFTGS_DEVICE;
  refuse(call, ": the arrays lie on ", on_device ? "a device" : "the host", ", expected them on ",
         renderer.draws_in == DrawsIn::host   ? "the host"
         : renderer.draws_in == DrawsIn::cuda ? "the device"
                                              : "the Vulkan device",
         ", where '", renderer.name, "' draws");
}

}  // namespace

Scene to_scene(const swiftgs_gaussians* given) { return to_scene(read_gaussians(given)); }

}  // namespace swiftgs::c

using namespace swiftgs::c;

extern "C" {

swiftgs_status swiftgs_renderer_set_gaussians(swiftgs_renderer* renderer,
                                              const swiftgs_gaussians* gaussians) {
  return guarded([&] {
    const Turn any = of(renderer);
    const swiftgs_gaussians from = read_gaussians(gaussians);
    if (!lie_where_drawn(*renderer, from)) {
      any->set_scene(std::make_shared<const swiftgs::Scene>(to_scene(from)), swiftgs::HarmonicsKept::floats);
    } else {
      in_stream_order(*renderer, from, [&](const swiftgs::SceneArrays& arrays) { any->set_scene(arrays); });
    }
    renderer->shown.reset();
  });
}

swiftgs_status swiftgs_renderer_borrow_gaussians(swiftgs_renderer* renderer,
                                                 const swiftgs_gaussians* gaussians) {
  return guarded([&] {
    const Turn any = of(renderer);
    const swiftgs_gaussians from = read_gaussians(gaussians);
    require_where_drawn("borrow_gaussians", *renderer, from);
    any->borrow_scene(to_arrays(from));
    renderer->shown.reset();
    if (from.memory == SWIFTGS_DEVICE) order_streams(from.stream, renderer->stream);
  });
}

swiftgs_status swiftgs_renderer_update_scene(swiftgs_renderer* renderer, uint64_t scene, uint64_t first,
                                             const swiftgs_gaussians* gaussians) {
  return guarded([&] {
    const Turn any = of(renderer);
    const swiftgs_gaussians from = read_gaussians(gaussians);
    if (renderer->draws_in == DrawsIn::vulkan && from.memory == SWIFTGS_HOST)
      return update_vulkan_scene(*any, std::size_t(scene), std::size_t(first), to_arrays(from));
    require_where_drawn("update_scene", *renderer, from);
    in_stream_order(*renderer, from, [&](const swiftgs::SceneArrays& arrays) {
      any->update_scene(std::size_t(scene), std::size_t(first), arrays);
    });
  });
}

}  // extern "C"
