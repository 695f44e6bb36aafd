// SPDX-License-Identifier: Apache-2.0

/// @file
/// Searches for a scene that a renderer draws worse than float can. `ratio_case.hpp` says what the bytes of
/// an input mean. The fuzzer keeps inputs that reach a new size of the normalised error, and so climbs
/// towards large ones. It prints the scene that fails.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include <swiftgs/bounds/ellipse.hpp>
#include <swiftgs/raster/axis_shared.hpp>
#include <swiftgs/raster/per_pixel.hpp>
#include <swiftgs/raster/split.hpp>
#include <swiftgs/renderer.hpp>
#include <swiftgs/serial.hpp>
#include <swiftgs/sort/early.hpp>
#include <swiftgs/stress.hpp>

#include "ratio_case.hpp"

namespace {

using namespace swiftgs;

constexpr double gate = 10;  // of the normalised error, see docs/stability.md

/// Buckets an octave, from a normalised error of 2^-8 to one of 2^8.
constexpr int buckets_per_octave = 8, octaves = 16, buckets = buckets_per_octave * octaves;

/// A row a renderer and kind of normalised error. libFuzzer takes each byte for the counter of a branch.
__attribute__((section("__libfuzzer_extra_counters"))) std::uint8_t reached[3 * 2][buckets];

struct Largest {
  double normalised_error = 0, normalised_depth_error = 0;
  ~Largest() {
    std::fprintf(stderr, "largest normalised error: %.3g, of depth %.3g\n", normalised_error,
                 normalised_depth_error);
  }
} largest;

void count(int row, double normalised_error) {
  if (!(normalised_error > 0)) return;
  const double bucket = (std::log2(normalised_error) + 0.5 * octaves) * buckets_per_octave;
  reached[row][std::size_t(std::clamp(bucket, 0.0, buckets - 1.0))] = 1;
}

[[noreturn]] void fail(const StressCase& drawn, std::string_view renderer, const char* what, double value,
                       std::size_t pixel) {
  fuzz::print(drawn);
  std::fprintf(stderr, "%.*s: %s is %g (pixel %zu)\n", int(renderer.size()), renderer.data(), what, value,
               pixel);
  std::abort();
}

void require_finite(const StressCase& drawn, std::string_view renderer, const char* plane,
                    const std::vector<float>& values, std::size_t channels) {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!std::isfinite(values[i])) fail(drawn, renderer, plane, double(values[i]), i / channels);
}

template <class Raster>
void draw_and_judge(const StressCase& drawn, const ConditionedFrame& reference, int index) {
  using Drawn = Renderer<Serial, EarlySort, Raster, Ellipse>;
  Drawn renderer;
  RenderSettings settings;
  settings.conventions = drawn.conventions;
  settings.background = drawn.background;
  settings.outputs = {.alpha = true, .depth = true};
  const Frame frame = renderer.render(renderer.backend().upload(drawn.scene), drawn.camera, settings);
  require_finite(drawn, Drawn::name, "colour", frame.colour, 3);
  require_finite(drawn, Drawn::name, "alpha", frame.alpha, 1);
  require_finite(drawn, Drawn::name, "depth", frame.depth, 1);

  const StressVerdict verdict = judge(reference, frame, exponent_representation_named(Raster::name));
  count(2 * index, verdict.normalised_error), count(2 * index + 1, verdict.normalised_depth_error);
  largest.normalised_error = std::max(largest.normalised_error, verdict.normalised_error);
  largest.normalised_depth_error = std::max(largest.normalised_depth_error, verdict.normalised_depth_error);
  if (!(verdict.normalised_error <= gate))
    fail(drawn, Drawn::name, "normalised error", verdict.normalised_error, verdict.worst_pixel);
  if (!(verdict.normalised_depth_error <= gate))
    fail(drawn, Drawn::name, "normalised error of depth", verdict.normalised_depth_error,
         verdict.worst_pixel);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const StressCase drawn = fuzz::ratio_case(data, size);
  const ConditionedFrame reference = render_conditioned(drawn, {}, 1);
  draw_and_judge<AxisSharedThreshold<FloatCholesky>>(drawn, reference, 0);
  draw_and_judge<AxisShared<FloatSplit>>(drawn, reference, 1);
  draw_and_judge<PerPixel>(drawn, reference, 2);
  return 0;
}
