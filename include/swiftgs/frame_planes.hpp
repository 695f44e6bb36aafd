// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include <swiftgs/frame.hpp>

namespace swiftgs {

/// Memory of the backend for the planes of frames: values of 4 bytes, one frame behind the other.
template <class B>
struct FramePlanes
    : PerPlane<typename B::template Buffer<float>, typename B::template Buffer<std::uint32_t>> {
  /// Makes room for `pixels` pixels. Earlier content is lost.
  void reset(Outputs outputs, std::size_t pixels) {
    for_each_plane([&](std::size_t channels, bool wanted,
                       auto& buffer) { buffer.reset(wanted ? channels * pixels : 0); },
                   outputs, *this);
  }

  /// Points the planes of `frame`, whose size is set, past the first `before` pixels.
  void place(FrameView& frame, std::size_t before) {
    for_each_plane(
        [&](std::size_t channels, auto& buffer, auto& plane) {
          if (buffer.size() != 0)
            plane = {buffer.data() + channels * before,
                     std::ptrdiff_t(channels * sizeof(float)) * frame.width};
        },
        *this, frame);
  }
};

}  // namespace swiftgs
