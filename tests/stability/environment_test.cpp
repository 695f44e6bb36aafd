// SPDX-License-Identifier: Apache-2.0

// Hard frames on threads with another floating-point environment than the default one.
#include "support/environment.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <string_view>
#include <utility>
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

/// An ordinary frame with numbers that are denormal or nearly so.
StressCase denormals() {
  stress::Random random(2);
  StressCase out = stress::usual_case(random, {83, 50}, 300, 3);
  const float denormal = std::numeric_limits<float>::denorm_min(), least = std::numeric_limits<float>::min();
  Scene& scene = out.scene;
  for (std::size_t i = 0; i < scene.size(); ++i) {
    if (i % 10 == 1) scene.scales[i] = vec3(denormal, 1e-20f, 0.5f);
    if (i % 10 == 3) scene.means[i].x = denormal, scene.means[i].y = -least / 3;
    if (i % 10 == 4) scene.opacities[i] = denormal;
    if (i % 10 == 5) scene.rotations[i] = {1, denormal, -least / 2, least};
    if (i % 10 == 6) scene.sh0[i] = vec3(denormal, -denormal, least);
    if (i % 10 == 7) scene.means[i].z = denormal;
  }
  return out;
}

/// Whether some digits are lost in `environment` that are kept where it is usual.
bool flushed(const Environment& environment, std::string_view family, double severity) {
  // Factors of splats at this depth are denormal.
  return environment.flush && (family == "denormals" || (family == "far-depths" && severity > 1e35));
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

TEST_CASE("stability: an environment is in force while it is set and gone afterwards") {
  volatile float one = 1, tiny = 0x1p-30f, least = std::numeric_limits<float>::min(), half = 0.5f;
  {
    const ScopedEnvironment scope(environments[1]);
    CHECK(one + tiny > 1);
  }
  CHECK(one + tiny == 1);
#if defined(__SSE__)
  {
    const ScopedEnvironment scope(environments[4]);
    CHECK(least * half == 0);
  }
#endif
  CHECK(least * half > 0);
}

// A family's severities share the environments among them: each environment draws the family once.
TEST_CASE("stability: every family is drawn in every environment and by the CPU with the same bits") {
  std::vector<std::unique_ptr<Renderers>> made_inside, made_outside;
  for (const Environment& environment : environments) {
    made_outside.push_back(std::make_unique<Renderers>(environment));
    const ScopedEnvironment scope(environment);  // which an arena of oneTBB keeps
    made_inside.push_back(std::make_unique<Renderers>(environment));
  }
  std::size_t directed = 0, otherwise = 0;  // frames of `Serial` that are rounded to one side
  // In each `step`-th environment from `first` on.
  const auto check = [&](StressCase drawn, std::string_view family, double severity,
                         const std::vector<std::unique_ptr<Renderers>>& all, std::size_t first = 0,
                         std::size_t step = 1) {
    CAPTURE(family);
    CAPTURE(severity);
    CaseJudge judge(std::move(drawn));
    all.front()->cpu.check(judge, Extent::all);
    const std::vector<Frame> usual = all.front()->cpu.frames(judge.drawn()),
                             by_serial = all.front()->serial.frames(judge.drawn());
    for (std::size_t k = first; k < all.size(); k += step) {
      Renderers* const inside = all[k].get();
      const Environment& environment = inside->environment;
      CAPTURE(environment.name);
      double gate = flushed(environment, family, severity) ? INFINITY : normalised_error_gate;
      if (environment.rounding != FE_TONEAREST) gate = std::max(gate, directed_gate(family, severity));
      inside->serial.check(judge, Extent::all, {.most_normalised_error = gate});
      const std::vector<Frame> frames = inside->cpu.frames(judge.drawn());
      for (std::size_t i = 0; i < usual.size(); ++i) CHECK(same_planes(frames[i], usual[i]));
      if (environment.rounding == FE_TONEAREST) continue;
      ++directed, otherwise += !same_planes(inside->serial.frames(judge.drawn())[0], by_serial[0]);
    }
  };
  std::size_t cases = 0;
  for (const StressFamily& family : stress_families()) {
    const std::size_t count = family.severities.size();
    for (std::size_t i = 0; i < count; ++i, ++cases)
      check(family.make(family.severities[i], 45, {40, 24}), family.name, family.severities[i],
            cases % 2 == 0 ? made_outside : made_inside, i, count);
  }
  for (const auto* const all : {&made_inside, &made_outside}) check(denormals(), "denormals", 0, *all);
  CHECK(otherwise > directed / 2);
}

}  // namespace
}  // namespace swiftgs::test
