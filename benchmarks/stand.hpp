// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include <benchmark/benchmark.h>

#include <swiftgs/any_renderer.hpp>

#include "inputs.hpp"

namespace swiftgs::bench {

/// Where benchmarks run: one scene and one renderer at a time, kept while benchmarks ask for the same. Google
/// Benchmark calls a benchmark several times, and none of these calls should load a scene again.
class Stand {
 public:
  /// Renders every view of `views` in each iteration and reports the mean duration of one as manual time,
  /// with the stages' means, visible splats, intersections and the peak memory of the process as counters.
  /// `reported` chooses the duration.
  void run(benchmark::State& state, const RendererEntry& entry, const Input& input,
           const std::vector<Camera>& views, double StageTimes::*reported);

  /// Whether a benchmark ended with an error.
  bool failed() const { return failed_; }

 private:
  void prepare(const RendererEntry& entry, const Input& input, const std::vector<Camera>& views);
  StageTimes render(const std::vector<Camera>& views, Statistics& statistics);

  std::string scene_name_;
  std::shared_ptr<const Scene> scene_;
  std::unique_ptr<AnyRenderer> renderer_;
  RenderSettings settings_;
  Frame frame_;
  bool failed_ = false;
};

/// Registers `what/backend/sort/raster/bounds/scene/size` in milliseconds. `stand` and `entry` must outlive
/// the run.
void add_benchmark(std::string_view what, Stand& stand, const RendererEntry& entry, const Input& input,
                   const std::vector<Camera>& views, double StageTimes::*reported);

/// Registers the benchmarks of a program on `input`. Each program defines it.
void add_benchmarks(Stand& stand, const Input& input);

}  // namespace swiftgs::bench
