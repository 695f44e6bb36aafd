// SPDX-License-Identifier: Apache-2.0
#include "stand.hpp"

#include <exception>
#include <string>
#include <utility>

#include <sys/resource.h>

namespace swiftgs::bench {
namespace {

StageTimes operator*(double factor, const StageTimes& t) {
  return {factor * t.project, factor * t.sort, factor * t.raster, factor * t.total};
}

StageTimes operator+(const StageTimes& a, const StageTimes& b) {
  return {a.project + b.project, a.sort + b.sort, a.raster + b.raster, a.total + b.total};
}

/// Most memory that the process has held so far. @units{MiB}
double peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return double(usage.ru_maxrss) / 1024;
}

}  // namespace

void Stand::prepare(const RendererEntry& entry, const Input& input, const std::vector<Camera>& views) {
  if (scene_name_ != input.name) {
    renderer_.reset(), scene_.reset();
    scene_ = std::make_shared<const Scene>(input.load());
    scene_name_ = input.name;
    settings_.time = true;
  }
  if (renderer_ && renderer_->name() == entry.name) return;
  renderer_.reset();
  renderer_ = entry.make();
  renderer_->set_scene(scene_);
  // Buffers grow in the first frame; the adaptive sort measures each strategy in four frames, then decides.
  const int warm_ups = entry.name.find("/adaptive/") != std::string_view::npos ? 8 : 1;
  for (int i = 0; i < warm_ups; ++i) renderer_->render(views.front(), settings_, frame_);
}

StageTimes Stand::render(const std::vector<Camera>& views, Statistics& statistics) {
  StageTimes sum;
  for (const Camera& view : views) {
    renderer_->render(view, settings_, frame_);
    sum = sum + renderer_->times();
    const Statistics counts = renderer_->statistics();
    statistics.visible += counts.visible, statistics.intersections += counts.intersections;
  }
  return 1.0 / double(views.size()) * sum;
}

void Stand::run(benchmark::State& state, const RendererEntry& entry, const Input& input,
                const std::vector<Camera>& views, double StageTimes::*reported) {
  try {
    prepare(entry, input, views);
    StageTimes sum;
    Statistics statistics;
    for ([[maybe_unused]] auto iteration : state) {
      const StageTimes ms = render(views, statistics);
      state.SetIterationTime(ms.*reported / 1000);
      sum = sum + ms;
    }
    using benchmark::Counter;
    const double part = 1 / double(views.size());
    state.counters["project_ms"] = Counter(sum.project, Counter::kAvgIterations);
    state.counters["sort_ms"] = Counter(sum.sort, Counter::kAvgIterations);
    state.counters["raster_ms"] = Counter(sum.raster, Counter::kAvgIterations);
    state.counters["visible"] = Counter(part * double(statistics.visible), Counter::kAvgIterations);
    state.counters["intersections"] =
        Counter(part * double(statistics.intersections), Counter::kAvgIterations);
    state.counters["peak_mib"] = peak_memory();
  } catch (const std::exception& error) {
    failed_ = true;
    state.SkipWithError(error.what());
  }
}

void add_benchmark(std::string_view what, Stand& stand, const RendererEntry& entry, const Input& input,
                   const std::vector<Camera>& views, double StageTimes::*reported) {
  std::string name(what);
  name.append("/").append(entry.name).append("/").append(input.name).append("/").append(input.size());
  benchmark::RegisterBenchmark(name.c_str(),
                               [&stand, &entry, input, views, reported](benchmark::State& s) {
                                 stand.run(s, entry, input, views, reported);
                               })
      ->UseManualTime()
      ->Unit(benchmark::kMillisecond);
}

}  // namespace swiftgs::bench
