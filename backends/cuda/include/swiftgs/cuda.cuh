// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Definitions behind `<swiftgs/cuda.hpp>` for code that nvcc compiles: loops over functors, bounds and
/// rasterizers of your own, whose functions are `SWIFTGS_HD`. Compile sources that use bounds of your own
/// with `-fmad=false`: one kernel counts tiles and another emits them, and both must round alike. With that
/// option, rasterizers of your own decide as on hosts.

#include <swiftgs/bounds/all.hpp>
#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/intersections.cuh>
#include <swiftgs/cuda/launch.cuh>
#include <swiftgs/cuda/project.cuh>
#include <swiftgs/cuda/raster_pixels.cuh>
#include <swiftgs/raster/all.hpp>

namespace swiftgs {

/// Bounds without kernels in the library. The library has kernels for `AllBounds`, compiled with the flag
/// that they need.
template <class Bounds>
concept OwnBounds = BoundsPolicy<Bounds> && !AllBounds::contains<Bounds>;

template <OwnBounds Bounds>
void project(Cuda& cuda, const FramePlan& plan, const Bounds& bounds, ProjectScratch<Cuda>& scratch,
             Splats<Cuda>& splats, Footprints<Cuda>& footprints) {
  kernels::run_project(cuda, plan, bounds, scratch, splats, footprints);
}

template <OwnBounds Bounds>
void bin(Cuda& cuda, const FramePlan& plan, const Bounds& bounds, Splats<Cuda>& splats,
         Footprints<Cuda>& footprints) {
  kernels::run_bin(cuda, plan, bounds, splats, footprints);
}

template <OwnBounds Bounds, class Key>
Count emit_intersections(Cuda& cuda, const SortJob& job, const Bounds& bounds, const std::uint32_t* order,
                         IntersectionScratch<Cuda>& scratch, Pairs<Cuda, Key>& intersections) {
  return kernels::run_emission(cuda, job, bounds, order, scratch, intersections);
}

/// Rasterizers that the library does not instantiate. One with an overload of `rasterize` for `Cuda` keeps
/// it.
template <class R>
concept OwnRaster = RasterPolicy<R> && !AllRasters::contains<R>;

template <OwnRaster R>
void rasterize(Cuda& cuda, R, const RasterJob& job) {
  kernels::run_raster_pixels<R>(cuda, job);
}

}  // namespace swiftgs
