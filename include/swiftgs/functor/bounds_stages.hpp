// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <tuple>

#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/backend.hpp>
#include <swiftgs/frame/bounds.hpp>
#include <swiftgs/frame/frame_plan.hpp>
#include <swiftgs/frame/placing.hpp>
#include <swiftgs/frame/splats.hpp>
#include <swiftgs/frame/stored_scenes.hpp>
#include <swiftgs/project/project.hpp>

namespace swiftgs {

/// Memory of the projection stage between its two steps.
template <class B>
struct ProjectScratch {
  typename B::template Buffer<ProjectedShape> projected;
  typename B::template Buffer<std::uint32_t> slots;

  void reserve(B&, const Reservation& reserved) {
    projected.reset_exactly(reserved.gaussians), slots.reset_exactly(reserved.gaussians);
  }
  static auto buffers(auto& self) { return std::tie(self.projected, self.slots); }
};

/// Projects Gaussian i and marks it with 1 where it is visible.
struct SWIFTGS_API ProjectShapes {
  ViewConstants camera;  ///< the eye of a placed scene
  SceneView scene;
  Clip clip;
  ProjectedShape* projected;
  std::uint32_t* slots;

  SWIFTGS_HD void operator()(std::size_t i) const {
    projected[i] = clip.shows(scene.means[i]) ? project_shape(camera, gaussian(scene, i)) : ProjectedShape();
    slots[i] = projected[i].visible;
  }
};

/// Moves visible Gaussian i to its slot.
struct SWIFTGS_API CompactSplats {
  const ProjectedShape* projected;
  const std::uint32_t* slots;
  std::uint32_t first_gaussian;  ///< of the placed scene
  std::uint16_t view;
  SplatShape* shapes;
  float* depths;
  std::uint32_t* gaussians;
  std::uint16_t* of_view;  ///< null if there is one view

  SWIFTGS_HD void operator()(std::size_t i) const {
    if (!projected[i].visible) return;
    const std::uint32_t slot = slots[i];
    shapes[slot] = projected[i].shape, depths[slot] = projected[i].depth;
    gaussians[slot] = first_gaussian + std::uint32_t(i);
    if (of_view) of_view[slot] = view;
  }
};

namespace detail {
/// The loops of `project`, which appends the splats of one view and placed scene after the other. Not
/// inlined: a compiler may fuse multiplications and additions differently in each copy, and all conservative
/// bounds must draw the same bits.
template <FunctorBackend B>
[[gnu::noinline]] void project_splats(B& b, const FramePlan& plan, ProjectScratch<B>& scratch,
                                      Splats<B>& splats) {
  const Views& views = plan.views;
  const std::size_t capacity = plan.limits.capacity.splats;
  splats.count = splats.visible = 0;
  const auto append = [&](std::size_t v, const StoredScene& placed) {
    const std::size_t n = placed.size();
    scratch.projected.reset(n), scratch.slots.reset(n);
    ViewConstants camera = eye(views.each[v].camera, placed);
    camera.set_pairs();  // a backend may run the loop on a device that reads them
    b.for_each(
        n, ProjectShapes{camera, placed.scene, placed.clip, scratch.projected.data(), scratch.slots.data()});
    const std::size_t visible = std::size_t(b.exclusive_scan(Span{scratch.slots.data(), n}));
    const std::size_t before = splats.count;
    splats.visible += visible;
    if (capacity != 0 && splats.visible > capacity) return;
    splats.resize(before + visible, views.size());
    b.for_each(n, CompactSplats{scratch.projected.data(), scratch.slots.data(), placed.first_gaussian,
                                std::uint16_t(v), splats.shapes.data() + before,
                                splats.depths.data() + before, splats.gaussians.data() + before,
                                views.size() > 1 ? splats.of_view.data() + before : nullptr});
    splats.count = before + visible;
  };
  for (std::size_t v = 0; v < views.size(); ++v)
    for (const StoredScene& placed : plan.scenes.shown(views[v])) append(v, placed);
}
}  // namespace detail

/// Projects the scenes of a frame: one splat for each Gaussian that is visible in a view. Reads no spherical
/// harmonics. Counts splats above the capacity, and leaves them out.
///
/// Backends overload this. An overload may also find `footprints` within `bounds` while it has the shapes;
/// the backend's `bin` then only settles their number.
template <FunctorBackend B, BoundsPolicy Bounds>
void project(B& b, const FramePlan& plan, const Bounds&, ProjectScratch<B>& scratch, Splats<B>& splats,
             Footprints<B>&) {
  detail::project_splats(b, plan, scratch, splats);
}

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
