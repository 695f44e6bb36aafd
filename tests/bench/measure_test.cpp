// SPDX-License-Identifier: Apache-2.0
#include "bench/measure.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>

#include "bench/scripted_renderer.hpp"

using namespace swiftgs;
using namespace swiftgs::cli;
using swiftgs::test::ScriptedRenderer;

namespace {

const auto steady = [](int) { return 2.0; };

std::vector<Samples> measure_scripted(std::vector<ScriptedRenderer>& renderers, const Plan& plan) {
  std::vector<AnyRenderer*> pointers;
  for (ScriptedRenderer& renderer : renderers) pointers.push_back(&renderer);
  const Camera camera = builtin_camera();
  return measure(pointers, {&camera, 1}, {}, plan);
}

}  // namespace

TEST_CASE("bench measure: a frame of several views counts for each with its share") {
  ScriptedRenderer renderer(
      "a", [](int) { return 6.0; }, nullptr);
  const std::vector<Camera> cameras(3, builtin_camera());
  const Samples samples =
      measure({&renderer}, {cameras.data(), cameras.size()}, {}, Plan{.min_frames = 2, .max_frames = 2})[0];
  for (const double total : samples.total) CHECK(total == 2);
  for (const double sort : samples.sort) CHECK(sort == doctest::Approx(0.4));
  CHECK(samples.frames() == 2);
}

TEST_CASE("bench summary: medians and intervals and percentiles of values that are known") {
  const Duration four = summary_of({4, 1, 3, 2}), one = summary_of({7});
  CHECK(std::vector{four.median, four.low, four.high} == std::vector{2.5, 1.0, 4.0});
  CHECK(std::vector{one.median, one.low, one.high, one.p10, one.p90} == std::vector<double>(5, 7));
  std::vector<double> values(101);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = double(100 - i);
  const Duration many = summary_of(values);
  CHECK(many.median == 50);
  CHECK(many.p10 == doctest::Approx(10));
  CHECK(many.p90 == doctest::Approx(90));
  CHECK_THROWS_AS(summary_of({}), std::invalid_argument);
}

TEST_CASE("bench summary: the interval holds the median of what is sampled in 95 of 100 cases") {
  std::mt19937 random(1);
  std::exponential_distribution<double> value(1);
  const double median = std::log(2.0);
  for (const int n : {8, 15, 31, 64}) {
    int held = 0;
    for (int trial = 0; trial < 2000; ++trial) {
      std::vector<double> values(std::size_t(n), 0.0);
      for (double& v : values) v = value(random);
      const Duration d = summary_of(values);
      held += d.low <= median && median <= d.high;
    }
    CAPTURE(n);
    CHECK(held >= 1880);  // three deviations, 10 each, below 95 % of 2000
  }
}

TEST_CASE("bench measure: a steady renderer stops at the least number of frames") {
  std::vector<ScriptedRenderer> renderers{{"steady", steady, nullptr}};
  const std::vector<Samples> samples = measure_scripted(renderers, {8, 48, 0.01, 1});
  CHECK(samples[0].frames() == 8);
  CHECK(samples[0].summary().sort.median == doctest::Approx(0.4));
}

TEST_CASE("bench measure: an unsteady one goes on to the most that are allowed") {
  const auto unsteady = [](int frame) { return frame % 2 ? 1.0 : 2.0; };
  std::vector<ScriptedRenderer> renderers{{"steady", steady, nullptr}, {"unsteady", unsteady, nullptr}};
  const std::vector<Samples> samples = measure_scripted(renderers, {8, 30, 0.01, 1});
  CHECK(samples[0].frames() == 8);
  CHECK(samples[1].frames() == 30);
}

TEST_CASE("bench measure: the first frame of a turn is not timed") {
  // Frame 1, 6, 11: the first of each turn of five.
  const auto slow_at_first = [](int frame) { return frame % 5 == 1 ? 1000.0 : 2.0; };
  std::vector<ScriptedRenderer> renderers{{"cold", slow_at_first, nullptr}};
  const std::vector<Samples> samples = measure_scripted(renderers, {12, 12, 0.01, 1});
  CHECK(*std::max_element(samples[0].total.begin(), samples[0].total.end()) == 2);
}

TEST_CASE("bench measure: renderers take turns in an order that changes and a seed that repeats it") {
  const auto order_of = [](std::uint32_t seed) {
    std::vector<std::string> calls;
    std::vector<ScriptedRenderer> renderers;
    for (const char* name : {"a", "b", "c", "d"}) renderers.emplace_back(name, steady, &calls);
    measure_scripted(renderers, {16, 16, 0.01, seed});
    return calls;
  };
  const std::vector<std::string> calls = order_of(5);
  CHECK(calls == order_of(5));
  CHECK(calls != order_of(6));
  REQUIRE(calls.size() == 4 * 4 * 5);
  // Everyone has had a turn before anyone has another.
  bool changes = false;
  for (std::size_t round = 0; round < 4; ++round) {
    std::vector<std::string> turns;
    for (std::size_t turn = 0; turn < 4; ++turn) turns.push_back(calls[20 * round + 5 * turn]);
    changes = changes || turns != std::vector<std::string>{calls[0], calls[5], calls[10], calls[15]};
    std::sort(turns.begin(), turns.end());
    CHECK(turns == std::vector<std::string>{"a", "b", "c", "d"});
  }
  CHECK(changes);
}

TEST_CASE("bench measure: a machine that drifts favours nobody") {
  // The machine becomes slower with every frame that anybody draws.
  int drawn = 0;
  const auto drifting = [&drawn](int) { return 1 + 0.001 * ++drawn; };
  std::vector<ScriptedRenderer> renderers;
  for (const char* name : {"a", "b", "c"}) renderers.emplace_back(name, drifting, nullptr);
  const std::vector<Samples> samples = measure_scripted(renderers, {200, 200, 0.01, 1});
  for (const Samples& one : samples)
    CHECK(one.summary().total.median == doctest::Approx(samples[0].summary().total.median).epsilon(0.02));
}

TEST_CASE("bench measure: plans without frames are errors") {
  for (const Plan& plan :
       {Plan{0, 5, 0.01, 1}, Plan{5, 4, 0.01, 1}, Plan{1, 4, 0, 1}, Plan{1, 4, std::nan(""), 1}})
    CHECK_THROWS_AS(validate(plan), std::invalid_argument);
  validate(Plan{1, 1, 0.5, 1});
}
