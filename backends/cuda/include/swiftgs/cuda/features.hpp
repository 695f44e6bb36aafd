// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The overloads for `Cuda` that a frame by `FloatCholesky` does without: of further rasterizers, of planes,
/// and of what counts, picks and sums up.

#include <cstddef>

#include <swiftgs/cuda/stages.hpp>
#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/passes.hpp>
#include <swiftgs/frame/raster.hpp>
#include <swiftgs/frame/stages.hpp>
#include <swiftgs/frame/stored_scenes.hpp>
#include <swiftgs/frame/views.hpp>
#include <swiftgs/raster/axis_shared.hpp>
#include <swiftgs/raster/split.hpp>

namespace swiftgs {

struct PerPixel;
/// One thread per pixel, splats in shared memory.
SWIFTGS_API void rasterize(Cuda& cuda, PerPixel, const RasterJob& job);
/// Terms in shared memory, eight splats at a time (SwiftGS, section 5.1).
SWIFTGS_API void rasterize(Cuda& cuda, AxisShared<HalfSplit>, const RasterJob& job);
SWIFTGS_API void rasterize(Cuda& cuda, AxisSharedThreshold<HalfSplit>, const RasterJob& job);
/// As those of `FloatCholesky`.
SWIFTGS_API void rasterize(Cuda& cuda, AxisShared<FloatSplit>, const RasterJob& job);
SWIFTGS_API void rasterize(Cuda& cuda, AxisSharedThreshold<FloatSplit>, const RasterJob& job);

template <>
inline constexpr bool may_gain_by_coarse_tiles<Cuda, AxisShared<FloatSplit>> = true;
template <>
inline constexpr bool may_gain_by_coarse_tiles<Cuda, AxisSharedThreshold<FloatSplit>> = true;

struct SplatAttributes;
/// One thread per splat.
SWIFTGS_API void gather_attributes(Cuda& cuda, const SplatAttributes& from, const StoredScenes& scenes,
                                   const Views& views, AttributeRow* to);

/// Downloads what `job` was rasterized from, and counts on all cores of the host. Waits.
SWIFTGS_API FrameCounted count_frame(const Cuda& cuda, const RasterJob& job,
                                     void (*count)(const RasterJob&, const RasterBlocks&, std::size_t));

struct PickJob;
/// One warp per pixel, eight pixels of a row in a thread block.
SWIFTGS_API void pick_pixels(Cuda& cuda, const PickJob& job);

struct ContributionJob;
/// One warp per warp block, with the bits of every weight that `AxisSharedThreshold<FloatCholesky>` blends
/// with.
SWIFTGS_API void add_contributions(Cuda& cuda, const ContributionJob& job);

}  // namespace swiftgs
