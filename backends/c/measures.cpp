// SPDX-License-Identifier: Apache-2.0

// What frames and renderers tell of themselves.
#include <cstddef>
#include <cstring>

#include <swiftgs/pick.hpp>
#include <swiftgs/statistics.hpp>

#include "error.hpp"
#include "renderer.hpp"
#include "structs.hpp"

namespace swiftgs::c {
namespace {

static_assert(sizeof(swiftgs_picked) == sizeof(PickedPixel) && SWIFTGS_NOTHING == PickedPixel::nothing &&
              offsetof(swiftgs_picked, gaussian) == offsetof(PickedPixel, gaussian) &&
              offsetof(swiftgs_picked, weight) == offsetof(PickedPixel, weight) &&
              offsetof(swiftgs_picked, depth) == offsetof(PickedPixel, depth) &&
              offsetof(swiftgs_picked, median) == offsetof(PickedPixel, median) &&
              offsetof(swiftgs_picked, median_depth) == offsetof(PickedPixel, median_depth));

swiftgs_statistics to_struct(const Statistics& from) {
  swiftgs_statistics to{};
  to.gaussians = from.gaussians, to.visible = from.visible, to.intersections = from.intersections;
  to.intersections_visited = from.raster.intersections_visited, to.rows_visited = from.raster.rows_visited;
  to.contributing_pairs = from.raster.contributing_pairs, to.pixels_stopped = from.raster.pixels_stopped;
  to.intersections_hidden = from.intersections_hidden;
  return to;
}

}  // namespace
}  // namespace swiftgs::c

using namespace swiftgs::c;

extern "C" {

swiftgs_status swiftgs_renderer_pick(swiftgs_renderer* renderer, uint64_t view, int32_t x, int32_t y,
                                     int32_t width, int32_t height, swiftgs_picked* picked) {
  return guarded([&] {
    const Turn any = of(renderer);
    require_pointer(picked, "picked");
    const auto found = any->pick({.x = x, .y = y, .width = width, .height = height, .view = view});
    std::memcpy(picked, found.data(), found.size() * sizeof(*picked));
  });
}

swiftgs_status swiftgs_renderer_times(swiftgs_renderer* renderer, swiftgs_times* times) {
  return guarded([&] {
    const swiftgs::StageTimes taken = of(renderer)->times();
    write_struct(times, {0, 0, taken.project, taken.sort, taken.raster, taken.total}, "swiftgs_times");
  });
}

swiftgs_status swiftgs_renderer_statistics(const swiftgs_renderer* renderer, swiftgs_statistics* statistics) {
  return guarded([&] {
    const Turn any = of(renderer);
    check_struct(statistics, "swiftgs_statistics");
    write_struct(statistics, to_struct(any->statistics()), "swiftgs_statistics");
  });
}

swiftgs_status swiftgs_renderer_memory(const swiftgs_renderer* renderer, swiftgs_memory* memory) {
  return guarded([&] {
    const Turn any = of(renderer);
    const swiftgs::StageMemory kept = any->memory();
    const swiftgs::MemoryUse device = any->device_memory().value_or(swiftgs::MemoryUse{});
    const std::size_t frames = renderer->host_frames ? renderer->host_frames->bytes() : 0;
    write_struct(memory, {0, 0, kept.project, kept.sort, kept.raster + frames, device.in_use, device.total},
                 "swiftgs_memory");
  });
}

}  // extern "C"
