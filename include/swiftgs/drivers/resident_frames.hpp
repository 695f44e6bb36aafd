// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <tuple>
#include <vector>

#include <swiftgs/camera.hpp>
#include <swiftgs/frame.hpp>
#include <swiftgs/frame/span.hpp>

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
  void point(FrameView& frame, std::size_t before) {
    for_each_plane(
        [&](std::size_t channels, auto& buffer, auto& plane) {
          if (buffer.size() != 0)
            plane = {buffer.data() + channels * before,
                     std::ptrdiff_t(channels * sizeof(float)) * frame.width};
        },
        *this, frame);
  }
};

/// Frames in the backend's memory.
template <class B>
class ResidentFrames {
 public:
  /// Makes one frame per camera, in place of earlier ones. They hold until the next call.
  Span<const FrameView> make(Span<const Camera> cameras, Outputs outputs) {
    std::size_t pixels = 0;
    frames_.clear();
    for (const Camera& camera : cameras) {
      frames_.push_back(
          {.width = camera.width, .height = camera.height, .feature_channels = outputs.features});
      pixels += frames_.back().pixels();
    }
    planes_.reset(outputs, pixels);
    std::size_t before = 0;
    for (FrameView& frame : frames_) {
      planes_.point(frame, before);
      before += frame.pixels();
    }
    return {frames_.data(), frames_.size()};
  }

  /// Copies all frames to the host, to frames of their sizes and outputs; complete when it returns.
  void download(const B& b, Span<Frame> to) const {
    std::size_t before = 0;
    for (Frame& frame : to) {
      for_each_plane(
          [&](std::size_t channels, const auto& buffer, auto& values) {
            if (!values.empty())
              b.download(Span{buffer.data() + channels * before, values.size()}, values.data());
          },
          planes_, frame);
      before += frame.pixels();
    }
  }

  static auto buffers(auto& self) { return std::tie(self.planes_); }

 private:
  FramePlanes<B> planes_;
  std::vector<FrameView> frames_;
};

}  // namespace swiftgs
