// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include <swiftgs/raster/raster.hpp>

namespace swiftgs {

/// What is counted on request.
struct FrameCounted {
  RasterCounts raster{};  ///< summed over raster blocks
  /// Intersections of splats whose means lie at or behind an occluder in all pixels of their tile.
  std::size_t intersections_hidden = 0;
};

/// Blends a raster block on the host and writes its counts.
using CountRasterBlock = void (*)(const RasterJob& job, const RasterBlocks& blocks, std::size_t block);

/// Counts of one frame.
struct Statistics {
  std::size_t gaussians = 0;      ///< in the scene
  std::size_t visible = 0;        ///< projected to splats; harmonics are evaluated for these
  std::size_t intersections = 0;  ///< pairs of splat and tile, of the tiles that the frame had
  /// Intersections whose splat's mean lies at or behind the occluder in all pixels of the tile; zero unless
  /// requested.
  std::size_t intersections_hidden = 0;
  RasterCounts raster{};  ///< summed over raster blocks; zero unless requested

  /// Whether occluders hide 99 % of the intersections or more. Mostly `FrameView::stored_depth` is missing.
  bool nearly_all_hidden() const {
    return intersections > 0 && 100 * (intersections - intersections_hidden) <= intersections;
  }

  double intersections_a_visible() const { return visible ? double(intersections) / double(visible) : 0.0; }
};

/// Durations of one frame's stages. `project` includes `bin`, and `shade` on hosts. A device evaluates
/// colours beside the sort; if they take longer than the sort, the rest counts in `raster`.
/// @units{milliseconds}
struct StageTimes {
  double project = 0, sort = 0, raster = 0, total = 0;
};

}  // namespace swiftgs
