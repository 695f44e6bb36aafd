// SPDX-License-Identifier: Apache-2.0

// Hard frames and exact decisions on a device.
#include <cstddef>
#include <vector>

#include "cuda/device.hpp"
#include "stability/sweep.hpp"

namespace swiftgs::test {
namespace {

/// Draws into the memory of a device and downloads what was drawn.
struct DrawOnDevice {
  template <class R>
  Frame operator()(R& renderer, const StressCase& drawn) const {
    Frame frame;
    prepare(frame, drawn.camera.width, drawn.camera.height, {true, true});
    const DeviceArrays arrays(drawn.scene);  // as a caller's own, which nothing looks at before
    DeviceBuffer<float> colour, alpha, depth, occluder;
    colour.reset(frame.colour.size()), alpha.reset(frame.alpha.size()), depth.reset(frame.depth.size());
    const std::size_t row = sizeof(float) * std::size_t(frame.width);
    FrameView view{.width = frame.width,
                   .height = frame.height,
                   .colour = {colour.data(), 3 * row},
                   .alpha = {alpha.data(), row},
                   .depth = {depth.data(), row}};
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

using Backends = Sweep<Cuda, DrawOnDevice>;
bool unavailable() { return without_device(); }

}  // namespace
}  // namespace swiftgs::test

#define SWIFTGS_STABILITY "cuda stability"
#include "stability/corner_cases.hpp"
#include "stability/edge_cases.hpp"
#include "stability/number_cases.hpp"
#include "stability/sweep_cases.hpp"
