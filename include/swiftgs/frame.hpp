// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include <swiftgs/frame/frame_view.hpp>

namespace swiftgs {

/// A rendered image on the host, rows from top to bottom. Planes that were not requested are empty.
/// @shape{height, width, channels}
struct Frame : PerPlane<std::vector<float>, std::vector<std::uint32_t>> {
  int width = 0, height = 0;
  int feature_channels = 0;

  std::size_t pixels() const { return std::size_t(width) * height; }
};

/// Gives `frame` the size and the arrays of `outputs`, and returns a view of them. Reuses the memory of
/// `frame`.
inline FrameView prepare(Frame& frame, int width, int height, Outputs outputs) {
  frame.width = width, frame.height = height, frame.feature_channels = outputs.features;
  FrameView view{.width = width, .height = height, .feature_channels = outputs.features};
  for_each_plane(
      [&](std::size_t channels, bool wanted, auto& values, auto& plane) {
        values.resize(wanted ? channels * frame.pixels() : 0);
        if (wanted) plane = {values.data(), std::ptrdiff_t(channels * sizeof values[0]) * width};
      },
      outputs, frame, view);
  return view;
}

/// Whether all values of `frame` are finite.
inline bool is_finite(const Frame& frame) {
  bool finite = true;
  for_each_plane(
      [&](std::size_t, const auto& values) {
        for (const auto value : values) finite = finite && std::isfinite(double(value));
      },
      frame);
  return finite;
}

/// Whether frames have the same planes, bit for bit.
inline bool same_planes(const Frame& a, const Frame& b) {
  bool same = true;
  for_each_plane(
      [&](std::size_t, const auto& of_a, const auto& of_b) {
        const std::size_t size = of_a.size();
        same = same && of_b.size() == size &&
               (size == 0 || std::memcmp(of_a.data(), of_b.data(), size * sizeof of_a[0]) == 0);
      },
      a, b);
  return same;
}

}  // namespace swiftgs
