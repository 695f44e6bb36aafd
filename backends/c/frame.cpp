// SPDX-License-Identifier: Apache-2.0

// Frames: drawn at once, or recorded.
#include <cstddef>
#include <cstdint>

#include "error.hpp"
#include "renderer.hpp"
#include "structs.hpp"
#include "view.hpp"

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
    const swiftgs_capacity asked_capacity = read_options(capacity, "swiftgs_capacity");
    require_zero(asked_capacity.reserved, "swiftgs_capacity");
    const swiftgs_frame asked = read_frame(frame);
    any->reserve(views_of(*renderer, asked),
                 {std::size_t(asked_capacity.splats), std::size_t(asked_capacity.intersections)});
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
