// SPDX-License-Identifier: Apache-2.0

// Hard frames and exact decisions on the serial backend and on every vector target of the cpu backend.
#include "stability/sweep.hpp"

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <hwy/targets.h>

#include <swiftgs/cpu.hpp>
#include <swiftgs/serial.hpp>

#include "policies/only_targets.hpp"

namespace swiftgs::test {
namespace {

/// Both backends of the host, the second with each vector target in turn.
class Backends {
 public:
  void check(CaseJudge& judge, Extent extent, Limits limits = {}) {
    serial_.check(judge, extent, limits);
    for_each_target(
        [&](bool first) { cpu_.check(judge, first ? Extent::all : Extent::rasterizers, limits); });
  }
  void check_square(CaseJudge& judge) { serial_.check_square(judge), cpu_.check_square(judge); }
  void check_bounds(const StressCase& drawn) {
    serial_.check_bounds(drawn);
    for_each_target([&](bool) { cpu_.check_bounds(drawn); });
  }
  template <class F>
  void for_each_frame(const StressCase& drawn, const F& f) {
    serial_.for_each_frame(drawn, f);
    for_each_target([&](bool) { cpu_.for_each_frame(drawn, f); });
  }
  std::vector<SplatShape> shapes(const StressCase& drawn) {
    std::vector<SplatShape> out = serial_.shapes(drawn);
    for_each_target([&](bool) {
      const std::vector<SplatShape> of_target = cpu_.shapes(drawn);
      out.insert(out.end(), of_target.begin(), of_target.end());
    });
    return out;
  }

 private:
  template <class F>
  static void for_each_target(const F& f) {
    bool first = true;
    for (const std::int64_t one : hwy::SupportedAndGeneratedTargets()) {
      const std::string target = hwy::TargetName(one);
      CAPTURE(target);
      const OnlyTargets only(one);
      f(std::exchange(first, false));
    }
  }

  Sweep<Serial> serial_;
  Sweep<Cpu> cpu_;
};

bool unavailable() { return false; }

}  // namespace
}  // namespace swiftgs::test

#define SWIFTGS_STABILITY "stability"
#include "stability/sweep_cases.hpp"
