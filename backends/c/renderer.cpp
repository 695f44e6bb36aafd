// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/c/renderer.h>

#include "device.hpp"
#include "error.hpp"
#include "scene.hpp"
#include "structs.hpp"
#include "view.hpp"

struct swiftgs_renderer {
  std::string name, device_name;
  std::unique_ptr<swiftgs::AnyRenderer> renderer;
  std::unique_ptr<swiftgs::c::HostFrames> host_frames{};  ///< null: the backend reaches the host's memory
  std::vector<swiftgs::View> views{};                     ///< of one call; their memory is kept
};

namespace swiftgs::c {
namespace {

static_assert(sizeof(swiftgs_report) == sizeof(FrameReport) &&
              offsetof(swiftgs_report, visible) == offsetof(FrameReport, visible) &&
              offsetof(swiftgs_report, instances) == offsetof(FrameReport, instances) &&
              offsetof(swiftgs_report, overflowed) == offsetof(FrameReport, overflowed));

/// Names that end in zero.
const std::vector<std::string>& names() {
  static const std::vector<std::string> all = [] {
    std::vector<std::string> copies;
    for (const RendererEntry& entry : renderers()) copies.emplace_back(entry.name);
    return copies;
  }();
  return all;
}

AnyRenderer& of(const swiftgs_renderer* renderer) {
  require_pointer(renderer, "renderer");
  return *renderer->renderer;
}

BackendOptions to_options(const swiftgs_renderer_options& from) {
  BackendOptions options{from.threads, static_cast<::CUstream_st*>(from.stream), {}};
  if (from.allocate || from.release) {
    options.memory = {from.allocate, from.release, from.context};
    validate(*options.memory);
  }
  return options;
}

swiftgs_frame read_frame(const swiftgs_frame* given) {
  const swiftgs_frame frame = read_struct(given, "swiftgs_frame");
  constexpr std::uint32_t known = SWIFTGS_MEASURE_COUNTS | SWIFTGS_MEASURE_TIMES;
  if (frame.measure & ~known)
    throw std::invalid_argument("swiftgs_frame: measure is " + std::to_string(frame.measure) +
                                ", expected a sum of 1 and 2");
  return frame;
}

Measures measures_of(const swiftgs_frame& frame) {
  return {(frame.measure & SWIFTGS_MEASURE_COUNTS) != 0, (frame.measure & SWIFTGS_MEASURE_TIMES) != 0};
}

/// The views of a frame, until the next call.
Span<const View> views_of(swiftgs_renderer& renderer, const swiftgs_frame& frame) {
  read_views(frame, renderer.views);
  return {renderer.views.data(), renderer.views.size()};
}

swiftgs_statistics to_struct(const Statistics& from) {
  swiftgs_statistics to{};
  to.gaussians = from.gaussians, to.visible = from.visible, to.instances = from.instances;
  to.instances_visited = from.raster.instances_visited, to.rows_visited = from.raster.rows_visited;
  to.contributing_pairs = from.raster.contributing_pairs, to.pixels_stopped = from.raster.pixels_stopped;
  to.pieces = from.raster.pieces, to.pixels_joined = from.raster.pixels_joined;
  to.longest_item = from.raster.longest_item;
  to.balanced_ms = from.balanced_ms();
  return to;
}

SortCalibration to_calibration(const swiftgs_calibration& from) {
  require_zero(from.reserved, "swiftgs_calibration");
  return {std::size_t(from.gaussians), from.width, from.height, from.standard_ms, from.early_ms};
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
    if (index >= all.size())
      throw std::invalid_argument("renderers: number " + std::to_string(index) + ", expected less than " +
                                  std::to_string(all.size()));
    write_struct(entry, {0, all[index].usable, names()[index].c_str()}, "swiftgs_renderer_entry");
  });
}

swiftgs_status swiftgs_renderer_create(const char* name, const swiftgs_renderer_options* options,
                                       swiftgs_renderer** renderer) {
  return guarded([&] {
    require_pointer(name, "name");
    require_pointer(renderer, "renderer");
    const auto given = to_options(read_options(options, "swiftgs_renderer_options"));
    auto made = std::make_unique<swiftgs_renderer>();
    made->renderer = swiftgs::make_renderer(name, given);
    made->name = name;
    made->device_name = made->renderer->device_name();
    if (made->renderer->device_memory()) made->host_frames = make_host_frames(given);
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
    of(renderer).set_scene(scene->scene);
  });
}

swiftgs_status swiftgs_renderer_share_scene(swiftgs_renderer* renderer, const swiftgs_renderer* other) {
  return guarded([&] {
    if (!of(renderer).share_scene(of(other)))
      throw std::invalid_argument("share_scene: renderer '" + other->name +
                                  "' has no scene or another backend, expected a scene of that of '" +
                                  renderer->name + "'");
  });
}

swiftgs_status swiftgs_renderer_render_into(swiftgs_renderer* renderer, const swiftgs_frame* frame) {
  return guarded([&] {
    swiftgs::AnyRenderer& any = of(renderer);
    const swiftgs_frame asked = read_frame(frame);
    any.render_into(views_of(*renderer, asked), measures_of(asked));
  });
}

swiftgs_status swiftgs_renderer_render(swiftgs_renderer* renderer, const swiftgs_frame* frame) {
  return guarded([&] {
    swiftgs::AnyRenderer& any = of(renderer);
    const swiftgs_frame asked = read_frame(frame);
    const auto views = views_of(*renderer, asked);
    if (renderer->host_frames)
      renderer->host_frames->render_into(any, views, measures_of(asked));
    else
      any.render_into(views, measures_of(asked));
  });
}

swiftgs_status swiftgs_renderer_reserve(swiftgs_renderer* renderer, const swiftgs_frame* frame,
                                        const swiftgs_capacity* capacity) {
  return guarded([&] {
    swiftgs::AnyRenderer& any = of(renderer);
    const swiftgs_capacity room = read_options(capacity, "swiftgs_capacity");
    require_zero(room.reserved, "swiftgs_capacity");
    const swiftgs_frame asked = read_frame(frame);
    any.reserve(views_of(*renderer, asked), {std::size_t(room.splats), std::size_t(room.instances)});
  });
}

swiftgs_status swiftgs_renderer_set_views(swiftgs_renderer* renderer, const swiftgs_frame* frame) {
  return guarded([&] {
    swiftgs::AnyRenderer& any = of(renderer);
    const swiftgs_frame asked = read_frame(frame);
    any.set_views(views_of(*renderer, asked));
  });
}

swiftgs_status swiftgs_renderer_record(swiftgs_renderer* renderer, swiftgs_report* report) {
  return guarded([&] { of(renderer).record(reinterpret_cast<swiftgs::FrameReport*>(report)); });
}

swiftgs_status swiftgs_renderer_wait(swiftgs_renderer* renderer) {
  return guarded([&] { of(renderer).wait(); });
}

swiftgs_status swiftgs_renderer_times(swiftgs_renderer* renderer, swiftgs_times* times) {
  return guarded([&] {
    const swiftgs::StageTimes taken = of(renderer).times();
    write_struct(times, {0, 0, taken.project, taken.sort, taken.raster, taken.total}, "swiftgs_times");
  });
}

swiftgs_status swiftgs_renderer_statistics(const swiftgs_renderer* renderer, swiftgs_statistics* statistics) {
  return guarded([&] {
    swiftgs::AnyRenderer& any = of(renderer);
    check_struct(statistics, "swiftgs_statistics");
    write_struct(statistics, to_struct(any.statistics()), "swiftgs_statistics");
  });
}

swiftgs_status swiftgs_renderer_memory(const swiftgs_renderer* renderer, swiftgs_memory* memory) {
  return guarded([&] {
    const swiftgs::StageMemory kept = of(renderer).memory();
    const swiftgs::MemoryUse device = of(renderer).device_memory().value_or(swiftgs::MemoryUse{});
    const std::size_t frames = renderer->host_frames ? renderer->host_frames->bytes() : 0;
    write_struct(memory, {0, 0, kept.project, kept.sort, kept.raster + frames, device.in_use, device.total},
                 "swiftgs_memory");
  });
}

swiftgs_status swiftgs_renderer_trim(swiftgs_renderer* renderer) {
  return guarded([&] {
    of(renderer).trim();
    if (renderer->host_frames) renderer->host_frames->trim();
  });
}

swiftgs_status swiftgs_renderer_calibration(const swiftgs_renderer* renderer,
                                            swiftgs_calibration* calibration) {
  return guarded([&] {
    const swiftgs::SortCalibration known = of(renderer).calibration().value_or(swiftgs::SortCalibration{});
    write_struct(calibration,
                 {0, known.width, known.height, 0, known.gaussians, known.standard_ms, known.early_ms},
                 "swiftgs_calibration");
  });
}

swiftgs_status swiftgs_renderer_use_calibrations(swiftgs_renderer* renderer,
                                                 const swiftgs_calibration* calibrations, size_t count) {
  return guarded([&] {
    swiftgs::AnyRenderer& any = of(renderer);
    std::vector<swiftgs::SortCalibration> saved;
    for_each_struct(calibrations, count, "swiftgs_calibration",
                    [&](const swiftgs_calibration& each) { saved.push_back(to_calibration(each)); });
    any.use_calibrations(std::move(saved));
  });
}

}  // extern "C"
