// SPDX-License-Identifier: Apache-2.0

// Hard frames and exact decisions on a device.
#include <cmath>

#include "cuda/draw_on_device.hpp"
#include "policies/random_splats.hpp"
#include "stability/climb_cases.hpp"

namespace swiftgs::test {
namespace {

using Backends = Sweep<Cuda, DrawOnDevice>;
bool unavailable() { return without_device(); }

}  // namespace
}  // namespace swiftgs::test

#define SWIFTGS_STABILITY "cuda stability"
#include "stability/sweep_cases.hpp"

namespace swiftgs::test {

SWIFTGS_DEVICE_CASE("cuda stability: a search finds no frame that a device draws worse than floats can") {
  check_climb<Cuda, DrawOnDevice>(20000);
}

SWIFTGS_DEVICE_CASE(
    "cuda stability: an occluder ends pixels of long lists where it ends those of counted frames") {
  // Lists so long that warps share them. Counted frames blend splats one by one, others in groups.
  StressCase drawn;
  drawn.camera = forward_camera(32, 32);
  drawn.conventions.alpha_min = 2e-5f;
  Random random(3);
  for (int i = 0; i < 6000; ++i) {
    const float y = random.f(-0.2, 0.2), x = random.f(-0.2, 0.2), side = float(random.scale(0.03, 0.3));
    const float faint = float(random.scale(1e-4, 3e-4));
    stress::add(drawn.scene, {.mean = {x, y, 2 + float(i) / 1000},
                              .scale = vec3(side),
                              .opacity = i == 0      ? 0.1f
                                         : i == 3000 ? 0.6f
                                                     : faint});
  }
  for (int i = 0; i < 32 * 32; ++i) drawn.occluder.push_back(random.f(2, 8));

  Renderer<Cuda, EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse> renderer;
  const ArraysOn<Cuda> arrays(renderer.backend(), drawn.scene);
  const auto check = [&] {
    const Frame frame = DrawOnDevice::draw(renderer, drawn, arrays, true);
    const Frame counted = DrawOnDevice::draw(renderer, drawn, arrays, true, true);
    CHECK(renderer.statistics().raster.segments > 0);
    CHECK(same_bits(frame.alpha, counted.alpha));
    CHECK(same_bits(frame.colour, counted.colour));
  };
  check();
  // The same where occluders are at the depths of splats.
  for (float& depth : drawn.occluder) depth = 2 + std::floor(1000 * (depth - 2)) / 1000;
  check();
}

}  // namespace swiftgs::test
