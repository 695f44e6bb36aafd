// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The stages of a frame of `Cuda`, as overloads. `<swiftgs/cuda/features.hpp>` has those of features.

#include <cstddef>
#include <cstdint>
#include <utility>

#include <swiftgs/cuda/stage_memory.hpp>
#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/bounds.hpp>
#include <swiftgs/frame/frame_plan.hpp>
#include <swiftgs/frame/placed_scene.hpp>
#include <swiftgs/frame/raster.hpp>
#include <swiftgs/frame/sort.hpp>
#include <swiftgs/frame/splats.hpp>
#include <swiftgs/frame/stored_scenes.hpp>
#include <swiftgs/frame/views.hpp>
#include <swiftgs/raster/axis_shared.hpp>
#include <swiftgs/raster/exponents.hpp>
#include <swiftgs/sort/early.hpp>

namespace swiftgs {

SWIFTGS_API Views store_views(Cuda& cuda, Span<const View> views, ViewStorage<Cuda>& storage,
                              ViewAccess access = ViewAccess::any);
/// A scene alone is handed to each loop by value, unless `access` asks for stored ones.
SWIFTGS_API StoredScenes store_scenes(Cuda& cuda, const PlacedScenes& scenes, Span<const View> views,
                                      SceneStorage<Cuda>& storage, ViewAccess access = ViewAccess::any);

/// One kernel: projects, compacts in the order of the Gaussians and finds tiles. Does not wait.
/// In the library for `AllBounds`; for others in `<swiftgs/cuda.cuh>`.
template <BoundsPolicy Bounds>
SWIFTGS_API void project(Cuda& cuda, const FramePlan& plan, const Bounds& bounds,
                         ProjectScratch<Cuda>& scratch, Splats<Cuda>& splats, Footprints<Cuda>& footprints);

/// Colours that are evaluated beside the sort, on a fork.
template <>
class [[nodiscard]] Shading<Cuda> {
 public:
  Shading(Cuda::Fork fork, const Splats<Cuda>& splats, const SplatColour* colours,
          const std::uint32_t* colourless)
      : fork_(std::move(fork)), splats_(&splats), colours_(colours), colourless_(colourless) {}

  /// Call it after `bin`, which sets the number of splats.
  ColoursView finish() {
    fork_.join();
    return {{colours_, splats_->count}, colourless_};
  }
  /// Until `finish`.
  void* stream() const { return fork_.stream(); }

 private:
  Cuda::Fork fork_;
  const Splats<Cuda>* splats_;
  const SplatColour* colours_;
  const std::uint32_t* colourless_;
};

/// Evaluates the colours of `splats`, whose number it reads where the device keeps it, beside all later work
/// until `Shading::finish`.
SWIFTGS_API Shading<Cuda> shade(Cuda& cuda, const FramePlan& plan, const Splats<Cuda>& splats,
                                Colours<Cuda>& colours);

/// The device compares the numbers of splats and of intersections with the limits. Waits for the numbers if
/// the limits have no capacity of intersections. Finds footprints if `project` did not, and then waits for an
/// unknown number of splats. In the library for `AllBounds`; others: `<swiftgs/cuda.cuh>`.
template <BoundsPolicy Bounds>
SWIFTGS_API void bin(Cuda& cuda, const FramePlan& plan, const Bounds& bounds, Splats<Cuda>& splats,
                     Footprints<Cuda>& footprints);

/// Waits for that comparison. Afterwards the counts of `splats` and `footprints` are exact.
inline FrameReport await_report(Cuda& cuda, Splats<Cuda>& splats, Footprints<Cuda>& footprints,
                                const Limits&) {
  const FrameReport report = cuda.await_report();
  if (report.overflowed) return report;
  splats.count = footprints.count = std::size_t(report.visible), splats.exact = nullptr;
  footprints.intersections = std::size_t(report.intersections), footprints.overflowed = nullptr;
  return report;
}

/// `order_by_depth` from the depths themselves, whose bits are their keys.
inline const std::uint32_t* order_by_depth(Cuda& cuda, const SplatsView& splats,
                                           DepthOrderScratch<Cuda>& scratch) {
  const auto* const keys = reinterpret_cast<const std::uint32_t*>(splats.depths.data);
  cuda.sort_positions(keys, splats.count(), depth_key_bits, scratch.pairs);
  return scratch.pairs.values.data();
}

/// `emit_intersections` with the tiles of 32 splats spread over the lanes of a warp. It trusts the
/// footprints' number of intersections: a check would have to wait. In the library for `AllBounds`; for
/// others in `<swiftgs/cuda.cuh>`.
template <BoundsPolicy Bounds, class Key>
SWIFTGS_API Count emit_intersections(Cuda& cuda, const SortJob& job, const Bounds& bounds,
                                     const std::uint32_t* order, IntersectionScratch<Cuda>& scratch,
                                     Pairs<Cuda, Key>& intersections);

/// `group_by_tile` with keys no wider than the tiles need.
template <BoundsPolicy Bounds>
void group_by_tile(Cuda& cuda, const SortJob& job, const Bounds& bounds, const std::uint32_t* order,
                   GroupScratch<Cuda>& scratch, TileLists<Cuda>& lists) {
  const auto group = [&](auto& intersections) {
    const Count count = emit_intersections(cuda, job, bounds, order, scratch.emission, intersections);
    cuda.sort_pairs(intersections, count, job.footprints.views.tiles.key_bits());
    finish_lists(cuda, job.footprints, count, 0, intersections, lists);
  };
  job.footprints.views.tiles.key_bits() <= 16 ? group(scratch.narrow) : group(scratch.wide);
}

/// Terms in registers, one warp per warp block of 8x8 pixels.
SWIFTGS_API void rasterize(Cuda& cuda, AxisShared<FloatCholesky>, const RasterJob& job);
SWIFTGS_API void rasterize(Cuda& cuda, AxisSharedThreshold<FloatCholesky>, const RasterJob& job);

/// Warps test each listed splat once. Threads of rasterizers without warps evaluate it at every pixel.
template <>
inline constexpr bool may_gain_by_coarse_tiles<Cuda, AxisShared<FloatCholesky>> = true;
template <>
inline constexpr bool may_gain_by_coarse_tiles<Cuda, AxisSharedThreshold<FloatCholesky>> = true;

}  // namespace swiftgs
