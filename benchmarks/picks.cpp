// SPDX-License-Identifier: Apache-2.0

// What `pick` takes after a frame of the scene's first view, copy to the host included: `pick` at one pixel,
// and `rectangle` of 64x64. Places are spread over the image.
#include <cstddef>
#include <memory>
#include <string>

#include <benchmark/benchmark.h>

#include <swiftgs/any_renderer.hpp>

#include "stand.hpp"

namespace swiftgs::bench {
namespace {

/// A renderer that has drawn a frame, made when a benchmark of it runs.
using Drawn = std::shared_ptr<std::unique_ptr<AnyRenderer>>;

void pick(benchmark::State& state, const Drawn& drawn, const RendererEntry& entry, const Input& input,
          int side) {
  const Camera& camera = input.views.front();
  if (!*drawn) {
    *drawn = entry.make();
    (*drawn)->set_scene(std::make_shared<const Scene>(input.load()));
    (*drawn)->render_resident(camera, {});
  }
  int k = 0;
  for (auto _ : state) {
    // Along a diagonal that wraps around.
    const int x = 97 * k % (camera.width - side + 1), y = 61 * k % (camera.height - side + 1);
    benchmark::DoNotOptimize((*drawn)->pick({.x = x, .y = y, .width = side, .height = side}).data());
    ++k;
  }
}

}  // namespace

void add_benchmarks(Stand&, const Input& input) {
  for (const RendererEntry& entry : renderers()) {
    if (!entry.usable || !entry.name.ends_with("/early/axis-shared-threshold-float-cholesky/ellipse"))
      continue;
    const Drawn drawn = std::make_shared<std::unique_ptr<AnyRenderer>>();
    const auto add = [&](const char* what, int side) {
      const std::string name = std::string(what) + "/" + entry.name + "/" + input.name + "/" + input.size();
      benchmark::RegisterBenchmark(
          name.c_str(), [=, &entry](benchmark::State& state) { pick(state, drawn, entry, input, side); })
          ->UseRealTime()
          ->Unit(benchmark::kMicrosecond);
    };
    add("pick", 1), add("rectangle", max_pick_side);
  }
}

}  // namespace swiftgs::bench
