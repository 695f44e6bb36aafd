// SPDX-License-Identifier: Apache-2.0

// Hard frames on threads with another floating-point environment than the default one.
#include "support/environment.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <string_view>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/cpu.hpp>
#include <swiftgs/serial.hpp>

#include "stability/sweep.hpp"

namespace swiftgs::test {
namespace {

/// Draws in an environment.
struct DrawInside {
  Environment environment;

  template <class R>
  Frame operator()(R& renderer, const StressCase& drawn) const {
    const ScopedEnvironment scope(environment);
    return DrawOnHost()(renderer, drawn);
  }
};

struct Renderers {
  explicit Renderers(const Environment& inside)
      : environment(inside), serial(DrawInside{inside}), cpu(DrawInside{inside}) {}

  Environment environment;
  Sweep<Serial, DrawInside> serial;
  Sweep<Cpu, DrawInside> cpu;
};

/// Whether some digits are lost in `environment` that are kept where it is usual.
bool flushed(const Environment& environment, std::string_view family, double severity) {
  // Factors of splats at this depth are denormal.
  return environment.flush && family == "far-depths" && severity > 1e35;
}

/// The largest normalised error that is allowed where everything rounds to one side.
double directed_gate(std::string_view family, double severity) {
  // Depths round to other floats, and so to another order.
  if (family == "on-planes" || family == "on-ties") return INFINITY;
  if (family == "distant-cameras" && severity > 1e6) return INFINITY;
  // Transmittance drifts, where rounding to nearest walks at random.
  if (family == "equal-stacks" || family == "deep-stacks") return INFINITY;
  // A rounding may cost twice as much as one to nearest.
  return 2 * normalised_error_gate;
}

TEST_CASE("stability: every family is drawn in every environment and by the CPU with the same bits") {
  std::vector<std::unique_ptr<Renderers>> all;
  for (const Environment& environment : environments) {
    const ScopedEnvironment scope(environment);  // which an arena of oneTBB keeps
    all.push_back(std::make_unique<Renderers>(environment));
  }
  for (const StressFamily& family : stress_families())
    for (const double severity : family.severities) {
      CAPTURE(family.name);
      CAPTURE(severity);
      CaseJudge judge(family.make(severity, 45, {40, 24}));
      all.front()->cpu.check(judge, Extent::all);
      const std::vector<Frame> usual = all.front()->cpu.frames(judge.drawn());
      for (const auto& inside : all) {
        const Environment& environment = inside->environment;
        CAPTURE(environment.name);
        double gate = flushed(environment, family.name, severity) ? INFINITY : normalised_error_gate;
        if (environment.rounding != FE_TONEAREST) gate = std::max(gate, directed_gate(family.name, severity));
        inside->serial.check(judge, Extent::all, {.most_normalised_error = gate});
        const std::vector<Frame> frames = inside->cpu.frames(judge.drawn());
        for (std::size_t i = 0; i < usual.size(); ++i) CHECK(same_planes(frames[i], usual[i]));
      }
    }
}

}  // namespace
}  // namespace swiftgs::test
