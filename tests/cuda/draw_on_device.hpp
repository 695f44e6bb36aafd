// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "cuda/device.hpp"
#include "stability/sweep.hpp"

namespace swiftgs::test {

/// Draws into the memory of a device and downloads what was drawn. What a frame is asked for beside colour
/// and alpha chooses other kernels: both must draw the same.
struct DrawOnDevice {
  template <class R>
  Frame operator()(R& renderer, const StressCase& drawn) const {
    const DeviceArrays arrays(drawn.scene);  // as a caller's own, which nothing looks at before
    Frame frame = draw(renderer, drawn, arrays, true);
    if (drawn.occluder.empty()) {
      const Frame lean = draw(renderer, drawn, arrays, false);
      CHECK(same_bits(lean.colour, frame.colour));
      CHECK(same_bits(lean.alpha, frame.alpha));
    }
    return frame;
  }

 private:
  template <class R>
  static Frame draw(R& renderer, const StressCase& drawn, const DeviceArrays& arrays, bool with_depth) {
    Frame frame;
    prepare(frame, drawn.camera.width, drawn.camera.height, {true, with_depth});
    DeviceBuffer<float> colour, alpha, depth, occluder;
    colour.reset(frame.colour.size()), alpha.reset(frame.alpha.size()), depth.reset(frame.depth.size());
    const std::ptrdiff_t row = std::ptrdiff_t(sizeof(float)) * frame.width;
    FrameView view{.width = frame.width,
                   .height = frame.height,
                   .colour = {colour.data(), 3 * row},
                   .alpha = {alpha.data(), row}};
    if (with_depth) view.depth = {depth.data(), row};
    if (!drawn.occluder.empty()) {
      copy_to_device(Span<const float>{drawn.occluder.data(), drawn.occluder.size()}, occluder);
      view.occluder = {occluder.data(), row};
    }
    renderer.render_into(arrays.view(), drawn.camera, settings_of(drawn), view);
    renderer.backend().download(Span<const float>(colour.span()), frame.colour.data());
    renderer.backend().download(Span<const float>(alpha.span()), frame.alpha.data());
    renderer.backend().download(Span<const float>(depth.span()), frame.depth.data());
    return frame;
  }
};

}  // namespace swiftgs::test
