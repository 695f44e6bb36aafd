// SPDX-License-Identifier: Apache-2.0

// Whole frames that stay on the GPU, of every CUDA renderer: times, errors and memory, each as one line of
// JSON.
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

#include <swiftgs/swiftgs.hpp>

#include "gpu_bench.hpp"
#include "inputs.hpp"

namespace swiftgs::bench {
namespace {

/// Sorts next to each other, since they are compared.
template <class Raster, class Bounds>
void measure_sorts(GpuBench& bench) {
  bench.measure<StandardSort, Raster, Bounds>();
  bench.measure<EarlySort, Raster, Bounds>();
  bench.measure<AdaptiveSort, Raster, Bounds>();
}

template <class Raster>
void measure_bounds(GpuBench& bench) {
  measure_sorts<Raster, ThreeSigmaSquare>(bench);
  measure_sorts<Raster, OpacityBox>(bench);
  measure_sorts<Raster, Ellipse>(bench);
}

void measure_all(GpuBench& bench) {
  measure_bounds<PerPixel>(bench);
  measure_bounds<AxisShared<HalfSplit>>(bench);
  measure_bounds<AxisShared<FloatSplit>>(bench);
  measure_bounds<AxisShared<FloatCholesky>>(bench);
  measure_bounds<AxisSharedThreshold<HalfSplit>>(bench);
  measure_bounds<AxisSharedThreshold<FloatSplit>>(bench);
  measure_bounds<AxisSharedThreshold<FloatCholesky>>(bench);
}

/// What ctest takes for skipped.
constexpr int nothing_to_measure_on = 77;

constexpr const char* usage =
    "usage: gpu_frames OUT.jsonl [--renderers REGEX] [--frames N] [--views N] [--compared N] [--profile] "
    "[SCENE...]";

GpuOptions read_options(int argc, char** argv) {
  GpuOptions options;
  for (int i = 1; i < argc; ++i) {
    const std::string_view word = argv[i];
    if (!word.starts_with("--")) {
      if (options.out.empty())
        options.out = word;
      else
        options.scenes.emplace_back(word);
      continue;
    }
    if (word == "--profile") {
      options.profile = true;
      continue;
    }
    if (++i == argc) throw std::invalid_argument(usage);
    const auto number = [&](int least) {
      char* end = nullptr;
      const long value = std::strtol(argv[i], &end, 10);
      if (*end != '\0' || end == argv[i] || value < least || value > std::numeric_limits<int>::max())
        throw std::invalid_argument(std::string(word) + ": expected a number of at least " +
                                    std::to_string(least) + ", got '" + argv[i] + "'");
      return int(value);
    };
    if (word == "--renderers")
      options.renderers = argv[i];
    else if (word == "--frames")
      options.frames = number(1);
    else if (word == "--views")
      options.views = number(1);
    else if (word == "--compared")
      options.compared = number(0);
    else
      throw std::invalid_argument(usage);
  }
  if (options.out.empty()) throw std::invalid_argument(usage);
  return options;
}

}  // namespace
}  // namespace swiftgs::bench

int main(int argc, char** argv) {
  using namespace swiftgs;
  try {
    const bench::GpuOptions options = bench::read_options(argc, argv);
    if (!Cuda::usable()) {
      std::fprintf(stderr, "gpu_frames: expected a GPU that this build has kernels for\n");
      return bench::nothing_to_measure_on;
    }
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> out(std::fopen(options.out.c_str(), "w"),
                                                              std::fclose);
    if (!out) throw std::runtime_error(options.out + ": cannot be written");
    for (const bench::Input& input : bench::inputs_named(options.scenes)) {
      bench::GpuBench bench(options, input, out.get());
      bench::measure_all(bench);
    }
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "gpu_frames: %s\n", error.what());
    return 1;
  }
}
