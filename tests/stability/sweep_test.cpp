// SPDX-License-Identifier: Apache-2.0

// Hard frames on the serial backend and on every vector target of the cpu backend.
#include "stability/sweep.hpp"

#include <cmath>
#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <hwy/targets.h>

#include <swiftgs/cpu.hpp>
#include <swiftgs/serial.hpp>

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// Lets Highway choose among the given targets only, until the end of the scope.
class OnlyTargets {
 public:
  explicit OnlyTargets(std::int64_t targets) { choose(targets); }
  ~OnlyTargets() { choose(0); }
  OnlyTargets(const OnlyTargets&) = delete;
  OnlyTargets& operator=(const OnlyTargets&) = delete;

 private:
  static void choose(std::int64_t targets) {
    hwy::SetSupportedTargetsForTest(targets);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
};

using Names = std::vector<std::string_view>;
using Seeds = std::vector<std::uint64_t>;

const Names long_shapes{"needles", "pancakes", "ridges", "little-blur"};
const Names large_shapes{"grazing", "scales", "distant-means"};
const Names cameras{"wide-angles",   "long-lenses",   "principal-points",
                    "uneven-focals", "world-offsets", "skewed-rotations"};
const Names thresholds{"on-planes", "on-alphas", "on-stops", "on-ties"};
const Names stacks{"equal-stacks", "deep-stacks"};
const Names values{"harmonics", "backgrounds", "far-depths", "mixtures"};

/// Draws the families that are named on both backends, each vector target in turn.
void sweep(const Names& names, const Seeds& seeds, ImageSize size) {
  Sweep<Serial> serial;
  Sweep<Cpu> cpu;
  const std::vector<std::int64_t> targets = hwy::SupportedAndGeneratedTargets();
  for_each_case(names, seeds, size, [&](StressCase drawn) {
    CaseJudge judge(std::move(drawn));
    serial.check(judge, Extent::all);
    cpu.check(judge, Extent::all);
    for (std::size_t i = 1; i < targets.size(); ++i) {  // the first is the one that was just taken
      const std::string target = hwy::TargetName(targets[i]);
      CAPTURE(target);
      const OnlyTargets only(targets[i]);
      cpu.check(judge, Extent::rasterizers);
    }
  });
}

/// Draws one case on both backends.
void check_one(StressCase drawn, double least_db = -INFINITY) {
  CaseJudge judge(std::move(drawn));
  Sweep<Serial>().check(judge, Extent::rasterizers, least_db);
  Sweep<Cpu>().check(judge, Extent::all, least_db);
}

}  // namespace

TEST_CASE("stability: every family is swept") {
  std::set<std::string_view> swept;
  for (const Names& names : {long_shapes, large_shapes, cameras, thresholds, stacks, values})
    swept.insert(names.begin(), names.end());
  for (const StressFamily& family : stress_families()) CHECK(swept.count(family.name) == 1);
  CHECK(swept.size() == stress_families().size());
}

TEST_CASE("stability: long thin shapes are drawn as exactly as floats allow") {
  sweep(long_shapes, {1, 2, 35}, {});
}

TEST_CASE("stability: large and distant shapes are drawn as exactly as floats allow") {
  sweep(large_shapes, {3, 14, 40}, {});
}

TEST_CASE("stability: hard cameras are drawn as exactly as floats allow") { sweep(cameras, {5, 6, 27}, {}); }

TEST_CASE("stability: decisions on an edge are taken as exactly as floats allow") {
  sweep(thresholds, {7, 8, 9, 10, 12}, {});
}

TEST_CASE("stability: stacks of layers are drawn as exactly as floats allow") { sweep(stacks, {11}, {}); }

TEST_CASE("stability: extreme values are drawn as exactly as floats allow") {
  sweep(values, {13, 16, 44}, {});
}

TEST_CASE("stability: images that end within a tile are drawn as exactly as floats allow") {
  for (const Names& names : {long_shapes, large_shapes, cameras, thresholds, values}) {
    sweep(names, {17}, {33, 17});
    sweep(names, {18}, {200, 3});
  }
}

TEST_CASE("stability: an occluder ends pixels as exactly as floats allow") {
  Sweep<Serial> serial;
  Sweep<Cpu> cpu;
  for (const double steps : {0.0, 1.0, 2.0, 4.0})
    for (const std::uint64_t seed : {19u, 20u, 21u}) {
      CAPTURE(steps);
      CAPTURE(seed);
      CaseJudge judge(stress::on_occluders(steps, seed, {}));
      serial.check(judge, Extent::all);
      for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
        const OnlyTargets only(target);
        cpu.check(judge, Extent::all);
      }
    }
}

TEST_CASE("stability: squares of three sigmas are finite on every family") {
  Sweep<Serial> serial;
  Sweep<Cpu> cpu;
  for_each_case({}, {22}, {}, [&](StressCase drawn) {
    drawn.conventions = Conventions::inria();
    serial.check_square(drawn);
    cpu.check_square(drawn);
  });
}

TEST_CASE("stability: needles of ratio 1e4 across a large image") {
  check_one(stress::needles(1e4, 23, {960, 540}), 0);
}

TEST_CASE("stability: ridges of 1e4 pixels across a large image") {
  check_one(stress::ridges(1e4, 24, {960, 540}), 0);
}

TEST_CASE("stability: an image one pixel high and as wide as images may be") {
  check_one(stress::needles(1e2, 25, {max_image_side, 1}));
  check_one(stress::mixtures(200, 26, {max_image_side, 1}));
}
