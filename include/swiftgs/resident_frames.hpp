// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <tuple>
#include <vector>

#include <swiftgs/camera.hpp>
#include <swiftgs/frame.hpp>
#include <swiftgs/span.hpp>

namespace swiftgs {

/// Frames in the backend's memory, one behind the other in a buffer a plane.
template <class B>
class ResidentFrames {
 public:
  /// Makes one frame per camera, in place of earlier ones. They hold until the next call.
  Span<const FrameView> make(Span<const Camera> cameras, Outputs outputs) {
    std::size_t pixels = 0;
    for (const Camera& camera : cameras) pixels += std::size_t(camera.width) * std::size_t(camera.height);
    colour_.reset(3 * pixels), alpha_.reset(outputs.alpha ? pixels : 0);
    depth_.reset(outputs.depth ? pixels : 0);
    frames_.clear();
    std::size_t before = 0;
    for (const Camera& camera : cameras) {
      const auto row = std::ptrdiff_t(camera.width) * std::ptrdiff_t(sizeof(float));
      FrameView frame{.width = camera.width, .height = camera.height};
      frame.colour = {colour_.data() + 3 * before, 3 * row};
      if (outputs.alpha) frame.alpha = {alpha_.data() + before, row};
      if (outputs.depth) frame.depth = {depth_.data() + before, row};
      before += std::size_t(camera.width) * std::size_t(camera.height);
      frames_.push_back(frame);
    }
    return {frames_.data(), frames_.size()};
  }

  /// Copies all frames to the host, to frames of their sizes and outputs; complete when it returns.
  void download(const B& b, Span<Frame> to) const {
    std::size_t before = 0;
    for (Frame& frame : to) {
      const auto copy = [&](const auto& buffer, std::size_t channels, std::vector<float>& values) {
        if (!values.empty())
          b.download(Span<const float>{buffer.data() + channels * before, values.size()}, values.data());
      };
      copy(colour_, 3, frame.colour), copy(alpha_, 1, frame.alpha), copy(depth_, 1, frame.depth);
      before += frame.pixels();
    }
  }

  static auto buffers(auto& self) { return std::tie(self.colour_, self.alpha_, self.depth_); }

 private:
  typename B::template Buffer<float> colour_, alpha_, depth_;
  std::vector<FrameView> frames_;
};

}  // namespace swiftgs
