// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include <swiftgs/drivers/resident_frames.hpp>

#include "cuda/device.hpp"
#include "stability/sweep.hpp"

namespace swiftgs::test {

/// Draws into the memory of a device and downloads what was drawn. What a frame is asked for beside colour
/// and alpha chooses other kernels: both must draw the same.
struct DrawOnDevice {
  template <class R>
  Frame operator()(R& renderer, const StressCase& drawn) const {
    const ArraysOn<Cuda> arrays(renderer.backend(),
                                drawn.scene);  // as a caller's own, which nothing looks at before
    Frame frame = draw(renderer, drawn, arrays, true);
    if (drawn.occluder.empty()) {
      const Frame lean = draw(renderer, drawn, arrays, false);
      CHECK(same_bits(lean.colour, frame.colour));
      CHECK(same_bits(lean.alpha, frame.alpha));
    }
    return frame;
  }

  template <class R>
  static Frame draw(R& renderer, const StressCase& drawn, const ArraysOn<Cuda>& arrays, bool with_depth,
                    bool count = false) {
    Frame frame;
    FrameView view = prepare(frame, drawn.camera.width, drawn.camera.height, {true, with_depth});
    FramePlanes<Cuda> planes;
    planes.reset({true, with_depth}, frame.pixels());
    planes.point(view, 0);
    DeviceBuffer<float> occluder;
    if (!drawn.occluder.empty()) {
      copy_to_device(span_of(drawn.occluder), occluder);
      view.occluder = {occluder.data(), std::ptrdiff_t(sizeof(float)) * frame.width};
    }
    const PlacedScene placed{arrays.view(), drawn.world_from_scene, 1, drawn.clip};
    RenderSettings settings = settings_of(drawn);
    settings.count = count;
    renderer.render_into(Span<const PlacedScene>{&placed, 1}, drawn.camera, settings, view);
    for_each_plane([&](std::size_t, const auto& plane,
                       auto& values) { renderer.backend().download(plane.span(), values.data()); },
                   planes, frame);
    return frame;
  }
};

}  // namespace swiftgs::test
