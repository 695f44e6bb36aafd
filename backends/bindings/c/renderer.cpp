// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <memory>
#include <mutex>

#include <swiftgs/any_renderer.hpp>

#include "device.hpp"
#include "error.hpp"
#include "objects.hpp"
#include "structs.hpp"

namespace swiftgs::c {
namespace {

BackendOptions to_options(const swiftgs_renderer_options& from) {
  BackendOptions options{from.threads, static_cast<::CUstream_st*>(from.stream), {}};
  if (from.allocate || from.release) {
    options.memory = {from.allocate, from.release, from.context};
    validate(*options.memory);
  }
  return options;
}

static_assert(int(HarmonicsKept::floats) == SWIFTGS_HARMONICS_FLOAT &&
              int(HarmonicsKept::smallest) == SWIFTGS_HARMONICS_SMALLEST &&
              int(HarmonicsKept::halves) == SWIFTGS_HARMONICS_HALF);

HarmonicsKept to_harmonics(const swiftgs_renderer_options& from) {
  require_choice(from.harmonics, 3, "swiftgs_renderer_options: harmonics");
  require_zero(from.reserved, "swiftgs_renderer_options");
  return HarmonicsKept(from.harmonics);
}

void write_entry(swiftgs_renderer_entry* to, const RendererEntry& from) {
  write_struct(to, {0, from.usable, from.name.c_str(), where_draws(from.name) == DrawsIn::cuda, 0},
               "swiftgs_renderer_entry");
}

}  // namespace
}  // namespace swiftgs::c

using namespace swiftgs::c;

extern "C" {

swiftgs_status swiftgs_renderers_count(size_t* count) {
  return guarded([&] {
    require_pointer(count, "count");
    *count = swiftgs::renderers().size();
  });
}

swiftgs_status swiftgs_renderers_get(size_t index, swiftgs_renderer_entry* entry) {
  return guarded([&] {
    const auto& all = swiftgs::renderers();
    if (index >= all.size()) refuse("renderers: number ", index, ", expected less than ", all.size());
    write_entry(entry, all[index]);
  });
}

swiftgs_status swiftgs_renderers_find(const char* name, swiftgs_renderer_entry* entry) {
  return guarded([&] { write_entry(entry, swiftgs::find_renderer(name ? name : "")); });
}

swiftgs_status swiftgs_renderer_create(const char* name, const swiftgs_renderer_options* options,
                                       swiftgs_renderer** renderer) {
  return guarded([&] {
    require_pointer(name, "name");
    require_pointer(renderer, "renderer");
    const swiftgs_renderer_options read = read_options(options, "swiftgs_renderer_options");
    const auto given = to_options(read);
    auto made = std::make_unique<swiftgs_renderer>();
    made->harmonics = to_harmonics(read);
    made->renderer = swiftgs::make_renderer(name, given);
    made->name = name;
    made->device_name = made->renderer->device_name();
    made->draws_in = where_draws(made->name);
    if (made->draws_in == DrawsIn::cuda)
      made->host_frames = make_cuda_frames(given), made->stream = given.stream;
    if (made->draws_in == DrawsIn::vulkan) made->host_frames = make_vulkan_frames(given);
    *renderer = made.release();
  });
}

void swiftgs_renderer_free(swiftgs_renderer* renderer) { delete renderer; }

swiftgs_status swiftgs_renderer_name(const swiftgs_renderer* renderer, const char** name) {
  return guarded([&] {
    require_pointer(renderer, "renderer");
    require_pointer(name, "name");
    *name = renderer->name.c_str();
  });
}

swiftgs_status swiftgs_renderer_device_name(const swiftgs_renderer* renderer, const char** name) {
  return guarded([&] {
    require_pointer(renderer, "renderer");
    require_pointer(name, "name");
    *name = renderer->device_name.c_str();
  });
}

swiftgs_status swiftgs_renderer_set_scene(swiftgs_renderer* renderer, const swiftgs_scene* scene) {
  return guarded([&] {
    require_pointer(scene, "scene");
    const Turn any = of(renderer);
    any->set_scene(scene->scene, renderer->harmonics);
    renderer->shown.reset();
  });
}

swiftgs_status swiftgs_renderer_share_scene(swiftgs_renderer* renderer, const swiftgs_renderer* other) {
  return guarded([&] {
    require_pointer(renderer, "renderer");
    require_pointer(other, "renderer");
    const std::scoped_lock turns(renderer->turn, other->turn);
    if (renderer->draws_in == DrawsIn::cuda && other->draws_in == DrawsIn::cuda)
      order_streams(other->stream, renderer->stream);
    if (!renderer->renderer->share_scene(*other->renderer))
      refuse("share_scene: renderer '", other->name,
             "' has no scene or another backend, expected a scene of that of '", renderer->name, "'");
    renderer->shown.reset();
  });
}

swiftgs_status swiftgs_renderer_wait(swiftgs_renderer* renderer) {
  return guarded([&] { of(renderer)->wait(); });
}

swiftgs_status swiftgs_renderer_trim(swiftgs_renderer* renderer) {
  return guarded([&] {
    const Turn any = of(renderer);
    any->trim();
    renderer->recorded.reset();
    if (renderer->host_frames) renderer->host_frames->trim();
  });
}

}  // extern "C"
