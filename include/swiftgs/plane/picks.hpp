// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Planes that tell about one splat of each pixel: the first that shows, the median and the one of the
/// largest weight.

#include <cstddef>
#include <cstdint>

#include <swiftgs/frame/frame_view.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/passes.hpp>
#include <swiftgs/frame/raster.hpp>
#include <swiftgs/frame/splats.hpp>
#include <swiftgs/frame/views.hpp>

namespace swiftgs {

/// The transmittance that the median splat takes a pixel below.
inline constexpr float median_below = 0.5f;

/// Splats that a pixel remembers, by their numbers in the frame. Blended splats are offered front to back.
struct SplatPicks {
  static constexpr std::uint32_t none = 0xffffffff;

  std::uint32_t first = none, median = none, largest = none;
  float weight = 0;  ///< of the largest

  /// Offers the next splat: its weight, in any unit, and the transmittance behind it.
  SWIFTGS_HD void offer(std::uint32_t splat, float splat_weight, float transmittance, float first_below) {
    if (splat_weight > weight) largest = splat, weight = splat_weight;
    if (first == none && transmittance < first_below) first = splat;
    if (median == none && transmittance < median_below) median = splat;
  }
};

/// Writes the planes that `picks` tell about at column x of row y.
SWIFTGS_HD inline void store_picks(const FrameView& frame, const SplatsView& splats,
                                   Span<const SplatColour> colours, std::size_t x, std::size_t y,
                                   const SplatPicks& picks) {
  const auto depth = [&](std::uint32_t splat) {
    return splat == SplatPicks::none ? 0.0f : colours[splat].depth;
  };
  const auto id = [&](std::uint32_t splat) {
    return splat == SplatPicks::none ? no_gaussian : splats.gaussians[splat];
  };
  if (frame.first_depth.data) frame.first_depth.row(y)[x] = depth(picks.first);
  if (frame.median_depth.data) frame.median_depth.row(y)[x] = depth(picks.median);
  if (frame.id.data) frame.id.row(y)[x] = id(picks.largest);
  if (frame.median_id.data) frame.median_id.row(y)[x] = id(picks.median);
}

/// Writes the planes of picked splats at column x of row y.
SWIFTGS_HD inline void store_picks(const RasterJob& job, const View& view, std::size_t x, std::size_t y,
                                   const SplatPicks& picks) {
  store_picks(view.frame, job.splats, job.colours.each, x, y, picks);
  if (!view.camera.depth_along_ray) return;
  const auto depth = [&](std::uint32_t splat) {
    return splat == SplatPicks::none ? 0.0f : job.attributes.ray_depth(splat).at(point_of(view, x, y));
  };
  if (view.frame.first_depth.data) view.frame.first_depth.row(y)[x] = depth(picks.first);
  if (view.frame.median_depth.data) view.frame.median_depth.row(y)[x] = depth(picks.median);
}

}  // namespace swiftgs
