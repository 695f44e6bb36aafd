// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a frame counts on request, and how long its stages take.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <swiftgs/frame/raster.hpp>
#include <swiftgs/frame/views.hpp>

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

/// How many splats of a list, which runs front to back, lie at `depth` or behind.
inline std::size_t count_from(const RasterJob& job, const TileRange& list, float depth) {
  const std::uint32_t* const ids = job.lists.ids.data;
  const auto in_front = [&](std::uint32_t id) { return job.splats.depths[id] < depth; };
  return std::size_t(ids + list.end - std::partition_point(ids + list.begin, ids + list.end, in_front));
}

/// Intersections of `job`, in the host's memory, whose splats lie at or behind the occluder in all pixels of
/// their tile.
inline std::size_t count_hidden(const RasterJob& job) {
  std::size_t hidden = 0;
  for (const View& view : job.views) {
    const FrameView& frame = view.frame;
    if (!frame.occluder.data) continue;
    const int side = view.grid.side;
    for (int top = 0; top < frame.height; top += side)
      for (int left = 0; left < frame.width; left += side) {
        float farthest = -INFINITY;
        for (int y = top; y < std::min(top + side, frame.height); ++y)
          for (int x = left; x < std::min(left + side, frame.width); ++x) {
            const float depth = frame.occluder_at(std::size_t(x), std::size_t(y));
            farthest = std::max(farthest, depth >= -INFINITY ? depth : INFINITY);  // NaN hides nothing
          }
        const std::size_t tile = view.grid.tile_at(view.left() + left, view.top() + top);
        hidden += count_from(job, job.lists.ranges[tile], farthest);
      }
  }
  return hidden;
}

}  // namespace swiftgs
