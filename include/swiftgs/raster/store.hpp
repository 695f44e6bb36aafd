// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Stores all planes of a blended pixel.

#include <cstddef>

#include <swiftgs/plane/attributes.hpp>
#include <swiftgs/plane/picks.hpp>
#include <swiftgs/plane/ray_depth.hpp>
#include <swiftgs/raster/raster.hpp>
#include <swiftgs/store_pixel.hpp>

namespace swiftgs {

/// Writes the planes that `job` draws at column x of row y, but those of picked splats. `sums` are those of
/// its attributes.
SWIFTGS_HD inline void store_pixel(const RasterJob& job, const View& view, std::size_t x, std::size_t y,
                                   const BlendedPixel& pixel, const float* sums) {
  if (!job.only_attributes) store_pixel(view.frame, x, y, pixel, view.background);
  if (job.attributes.rows != 0) store_attributes(view, job.attributes, x, y, pixel.transmittance, sums);
}

/// Writes the planes of picked splats at column x of row y.
SWIFTGS_HD inline void store_picks(const RasterJob& job, const View& view, std::size_t x, std::size_t y,
                                   const SplatPicks& picks) {
  store_picks(view.frame, job.splats, job.colours.each, x, y, picks);
  if (!view.camera.depth_along_ray) return;
  const auto depth = [&](std::uint32_t splat) {
    return splat == SplatPicks::none ? 0.0f : job.attributes.ray_depth(splat).at(place_of(view, x, y));
  };
  if (view.frame.first_depth.data) view.frame.first_depth.row(y)[x] = depth(picks.first);
  if (view.frame.median_depth.data) view.frame.median_depth.row(y)[x] = depth(picks.median);
}

}  // namespace swiftgs
