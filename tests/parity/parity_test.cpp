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
#define SWIFTGS_METAMORPHIC "metamorphic"
#include "parity/metamorphic_cases.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

TEST_CASE("parity: cpu renderers give the same bits on 1 2 4 and 8 threads") {
  const Scene scene = with_features(make_builtin_scene(20'000), 5);
  RenderSettings settings = settings_of_all(5);
  settings.count = true;
  const auto check = [&](const auto& make) {
    Frame expected;
    std::uint64_t pairs = 0;
    for (const int threads : {1, 2, 4, 8}) {
      CAPTURE(threads);
      BoundRenderer<Cpu> renderer = make(threads);
      const Frame frame =
          renderer.render(renderer.backend().upload(scene), builtin_camera(256, 144), settings);
      const std::uint64_t found = renderer.statistics().raster.contributing_pairs;
      if (threads == 1) expected = frame, pairs = found;
      CHECK(same_planes(frame, expected));
      CHECK(found == pairs);
    }
  };
  with_each_raster<Cpu>([&](const BoundRaster<Cpu>& raster) {
    check([&](int threads) { return renderer_with<Cpu>(raster, Cpu(threads)); });
  });
  const auto raster = raster_stage<Cpu, PerPixel>();
  check(
      [&](int threads) { return renderer_with<Cpu, StandardSort, ThreeSigmaSquare>(raster, Cpu(threads)); });
  check([&](int threads) { return renderer_with<Cpu, AdaptiveSort, OpacityBox>(raster, Cpu(threads)); });
}
