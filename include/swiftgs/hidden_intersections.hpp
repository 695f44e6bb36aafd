// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How many tile intersections the occluders of a frame hide.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <swiftgs/raster/raster.hpp>
#include <swiftgs/views.hpp>

namespace swiftgs {

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
