// SPDX-License-Identifier: Apache-2.0

// Frames: drawn at once, or recorded.
// What frames and renderers tell of themselves.

#include <cstddef>
#include <cstdint>
#include <cstring>

#include <swiftgs/drivers/pick.hpp>
#include <swiftgs/drivers/statistics.hpp>

#include "error.hpp"
#include "objects.hpp"
#include "structs.hpp"

namespace swiftgs::c {
namespace {

static_assert(sizeof(swiftgs_report) == sizeof(FrameReport) &&
              offsetof(swiftgs_report, visible) == offsetof(FrameReport, visible) &&
              offsetof(swiftgs_report, intersections) == offsetof(FrameReport, intersections) &&
              offsetof(swiftgs_report, overflowed) == offsetof(FrameReport, overflowed));

swiftgs_frame read_frame(const swiftgs_frame* given) {
  const swiftgs_frame frame = read_struct(given, "swiftgs_frame");
  constexpr std::uint32_t known = SWIFTGS_MEASURE_COUNTS | SWIFTGS_MEASURE_TIMES;
  if (frame.measure & ~known)
    refuse("swiftgs_frame: measure is ", frame.measure, ", expected a sum of 1 and 2");
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

}  // namespace
}  // namespace swiftgs::c

using namespace swiftgs::c;

extern "C" {

swiftgs_status swiftgs_renderer_render_into(swiftgs_renderer* renderer, const swiftgs_frame* frame) {
  return guarded([&] {
    const Turn any = of(renderer);
    require_reachable("render_into", *renderer);
    const swiftgs_frame asked = read_frame(frame);
    any->render_into(views_of(*renderer, asked), measures_of(asked));
  });
}

swiftgs_status swiftgs_renderer_render(swiftgs_renderer* renderer, const swiftgs_frame* frame) {
  return guarded([&] {
    const Turn any = of(renderer);
    const swiftgs_frame asked = read_frame(frame);
    const auto views = views_of(*renderer, asked);
    if (renderer->host_frames)
      renderer->host_frames->render_into(*any, views, measures_of(asked));
    else
      any->render_into(views, measures_of(asked));
  });
}

swiftgs_status swiftgs_renderer_reserve(swiftgs_renderer* renderer, const swiftgs_frame* frame,
                                        const swiftgs_capacity* capacity) {
  return guarded([&] {
    const Turn any = of(renderer);
    require_reachable("reserve", *renderer);
    const swiftgs_capacity asked_capacity = read_options(capacity, "swiftgs_capacity");
    require_zero(asked_capacity.reserved, "swiftgs_capacity");
    const swiftgs_frame asked = read_frame(frame);
    any->reserve(views_of(*renderer, asked),
                 {std::size_t(asked_capacity.splats), std::size_t(asked_capacity.intersections)});
    renderer->recorded = renderer->shown;
  });
}

swiftgs_status swiftgs_renderer_set_views(swiftgs_renderer* renderer, const swiftgs_frame* frame) {
  return guarded([&] {
    const Turn any = of(renderer);
    const swiftgs_frame asked = read_frame(frame);
    any->set_views(views_of(*renderer, asked));
  });
}

swiftgs_status swiftgs_renderer_record(swiftgs_renderer* renderer, swiftgs_report* report) {
  return guarded([&] { of(renderer)->record(reinterpret_cast<swiftgs::FrameReport*>(report)); });
}

}  // extern "C"

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
