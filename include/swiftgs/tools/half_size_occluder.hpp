// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/frame_view.hpp>

namespace swiftgs {

/// Halves the occluder of `whole` for a frame through `scaled(camera, 0.5)`, on the host: each value is the
/// farthest depth of two by two pixels, so it hides no splat that one of the four shows. Rows lie densely,
/// and values are depths themselves. @shape{(height + 1) / 2, (width + 1) / 2} Throws `InvalidArgument`
/// if `whole` has no occluder.
inline std::vector<float> half_size_occluder(const FrameView& whole) {
  if (!whole.occluder.data)
    throw InvalidArgument("half_size_occluder: the frame has no occluder, expected one");
  const std::size_t width = std::size_t(whole.width), height = std::size_t(whole.height);
  std::vector<float> depths;
  depths.reserve((width + 1) / 2 * ((height + 1) / 2));
  for (std::size_t y = 0; y < height; y += 2)
    for (std::size_t x = 0; x < width; x += 2) {
      float farthest = -std::numeric_limits<float>::infinity();
      for (std::size_t row = y; row < std::min(y + 2, height); ++row)
        for (std::size_t column = x; column < std::min(x + 2, width); ++column) {
          const float depth = whole.occluder_at(column, row);
          farthest = std::isnan(depth) ? std::numeric_limits<float>::infinity() : std::max(farthest, depth);
        }
      depths.push_back(farthest);
    }
  return depths;
}

}  // namespace swiftgs
