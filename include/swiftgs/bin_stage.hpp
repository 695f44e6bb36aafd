// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include <swiftgs/backend.hpp>
#include <swiftgs/footprint.hpp>
#include <swiftgs/frame_plan.hpp>
#include <swiftgs/splats.hpp>

namespace swiftgs {

/// Finds the footprint of splat i.
template <class Bounds>
struct FindFootprint {
  SplatsView splats;
  const View* views;
  Bounds bounds;
  Footprint* footprints;

  SWIFTGS_HD void operator()(std::size_t i) const {
    footprints[i] = find_footprint(bounds, splats.shapes[i], views[splats.view(i)].grid);
  }
};

/// What the last `project` and `bin` found. On a host, splats above the capacity count as visible, but their
/// intersections do not count. Backends overload this.
template <FunctorBackend B>
requires(bool(B::reaches_host_memory)) FrameReport
    await_report(B&, const Splats<B>& splats, const Footprints<B>& footprints, const Limits& limits) {
  FrameReport report{splats.visible, footprints.intersections, 0};
  report.overflowed = !limits.fit(report);
  return report;
}

/// Finds the tiles of its view that each splat may touch within `bounds`, and the number of tile
/// intersections. After this stage the host knows the numbers of splats and of intersections.
///
/// Backends overload this. If projection found the footprints, the overload only learns their numbers. A
/// device waits only if the limits have no capacity of intersections; otherwise `await_report` tells the
/// numbers.
template <FunctorBackend B, BoundsPolicy Bounds>
requires(bool(B::reaches_host_memory)) void bin(B& b, const FramePlan& plan, const Bounds& bounds,
                                                Splats<B>& splats, Footprints<B>& footprints) {
  footprints.views = plan.views;
  const std::size_t n = splats.count;
  footprints.each.reset(n);
  footprints.count = n, footprints.intersections = 0;
  b.for_each(n, FindFootprint<Bounds>{splats.view(), plan.views.reachable(), bounds, footprints.each.data()});
  for (const Footprint& footprint : footprints.view().each) footprints.intersections += footprint.count;
  if (plan.limits.report) *plan.limits.report = await_report(b, splats, footprints, plan.limits);
}

}  // namespace swiftgs
