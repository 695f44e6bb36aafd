// SPDX-License-Identifier: Apache-2.0
#include <string_view>

#include <doctest/doctest.h>

namespace swiftgs::test {
namespace {
constexpr std::string_view backends[] = {"serial", "cpu"};
bool unavailable() { return false; }
}  // namespace
}  // namespace swiftgs::test

#define SWIFTGS_PARITY "parity"
#include "parity/parity_cases.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

TEST_CASE("parity: cpu renderers give the same bits on 1 2 4 and 8 threads") {
  const Scene scene = make_builtin_scene(20'000);
  const Camera camera = builtin_camera(256, 144);
  RenderSettings settings;
  settings.outputs = {true, true};
  const auto check = [&]<class Sort, class Raster, class Bounds>(Sort, Raster, Bounds) {
    Frame expected;
    for (const int threads : {1, 2, 4, 8}) {
      CAPTURE(threads);
      Renderer<Cpu, Sort, Raster, Bounds> renderer{Cpu(threads)};
      CAPTURE(renderer.name);
      const Frame frame = renderer.render(renderer.backend().upload(scene), camera, settings);
      if (threads == 1) expected = frame;
      CHECK(same_planes(frame, expected));
    }
  };
  check(StandardSort(), PerPixel(), ThreeSigmaSquare());
  check(EarlySort(), AxisShared<FloatSplit>(), OpacityBox());
  check(EarlySort(), AxisSharedThreshold<HalfSplit>(), Ellipse());
  check(AdaptiveSort(), AxisSharedThreshold<FloatCholesky>(), Ellipse());
}
