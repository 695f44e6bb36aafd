// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include <swiftgs/math.hpp>

namespace swiftgs {

/// A rendered image on the host, rows from top to bottom. What was not asked for is empty.
struct Frame {
  int width = 0, height = 0;
  std::vector<float> colour;  ///< @shape{height, width, 3} linear RGB, not clamped above
  std::vector<float> alpha;   ///< @shape{height, width} 1 - transmittance
  std::vector<float>
      depth;  ///< @shape{height, width} mean camera-space z, weighted by contribution; 0 where alpha is 0

  std::size_t pixels() const { return std::size_t(width) * height; }
};

/// Where a backend writes a frame: the caller's memory, reachable by that backend.
/// A null pointer is an output that is not wanted: alpha and depth are then not computed, colour not written.
struct FrameView {
  int width = 0, height = 0;
  float* colour = nullptr;  ///< RGB interleaved
  float* alpha = nullptr;
  float* depth = nullptr;
  std::size_t colour_pitch = 0;  ///< distance between rows @units{floats}; at least 3 width
  std::size_t alpha_pitch = 0;   ///< @units{floats}; at least width
  std::size_t depth_pitch = 0;   ///< @units{floats}; at least width
};

/// Outputs beside colour.
struct Outputs {
  bool alpha = false;
  bool depth = false;
};

/// Gives `frame` the size and the arrays that are asked for, and views them. Keeps memory that is already
/// there.
inline FrameView prepare(Frame& frame, int width, int height, Outputs outputs) {
  frame.width = width, frame.height = height;
  frame.colour.resize(3 * frame.pixels());
  frame.alpha.resize(outputs.alpha ? frame.pixels() : 0);
  frame.depth.resize(outputs.depth ? frame.pixels() : 0);
  return {.width = width,
          .height = height,
          .colour = frame.colour.data(),
          .alpha = outputs.alpha ? frame.alpha.data() : nullptr,
          .depth = outputs.depth ? frame.depth.data() : nullptr,
          .colour_pitch = 3 * std::size_t(width),
          .alpha_pitch = std::size_t(width),
          .depth_pitch = std::size_t(width)};
}

}  // namespace swiftgs
