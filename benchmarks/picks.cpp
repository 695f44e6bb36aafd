// SPDX-License-Identifier: Apache-2.0

// What `pick` takes after a frame of the scene's first view, copy to the host included: `pick` at one pixel,
// and `rectangle` of 64x64. Places are spread over the image.
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include <benchmark/benchmark.h>

#include <swiftgs/any_renderer.hpp>

#include "stand.hpp"

namespace swiftgs::bench {
namespace {

/// A renderer with a scene, made when a benchmark of it runs.
using Made = std::shared_ptr<std::unique_ptr<AnyRenderer>>;

void pick(benchmark::State& state, const Made& made, const RendererEntry& entry, const Input& input,
          int side) {
  const Camera& camera = input.views.front();
  const int width = std::min(side, camera.width), height = std::min(side, camera.height);
  if (!*made) {
    *made = entry.make();
    (*made)->set_scene(std::make_shared<const Scene>(input.load()));
  }
  std::int64_t k = 0;
  for (auto _ : state) {
    (*made)->render_resident(camera, {});
    // Along a diagonal that wraps around.
    const int x = int(97 * k % (camera.width - width + 1)), y = int(61 * k % (camera.height - height + 1));
    const auto from = std::chrono::steady_clock::now();
    benchmark::DoNotOptimize((*made)->pick({.x = x, .y = y, .width = width, .height = height}).data());
    state.SetIterationTime(std::chrono::duration<double>(std::chrono::steady_clock::now() - from).count());
    ++k;
  }
}

}  // namespace

void add_benchmarks(Stand&, const Input& input) {
  for (const RendererEntry& entry : renderers()) {
    if (!entry.usable || !entry.name.ends_with("/early/axis-shared-threshold-float-cholesky/ellipse"))
      continue;
    const Made made = std::make_shared<std::unique_ptr<AnyRenderer>>();
    const auto add = [&](const char* what, int side) {
      const std::string name = std::string(what) + "/" + entry.name + "/" + input.name + "/" + input.size();
      benchmark::RegisterBenchmark(
          name.c_str(), [=, &entry](benchmark::State& state) { pick(state, made, entry, input, side); })
          ->UseManualTime()
          ->Unit(benchmark::kMicrosecond);
    };
    add("pick", 1), add("rectangle", max_pick_side);
  }
}

}  // namespace swiftgs::bench
