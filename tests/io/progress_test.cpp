// SPDX-License-Identifier: Apache-2.0
#include <stdexcept>

#include "scenes.hpp"
#include "tasks.hpp"

namespace swiftgs::test::progress_test {

using namespace swiftgs::io;

// The palette of a SOG is found by squares of distances.
TEST_CASE("progress: harmonics so small that their squares are no floats do not turn it back") {
  for (const float factor : {1e-22f, 0.5e-22f, 0.25e-22f, 0.125e-22f}) {
    Scene scene = some_scene(1000, 1);
    for (float& value : scene.sh_rest) value *= factor;
    write_and_read(scene, ".sog");  // checks the progress of both
  }
}

TEST_CASE("progress: steps that overlap or round do not turn it back") {
  Listener listener;
  const Progress progress = listener.progress();
  const ProgressMeter meter(progress, "a");
  meter.report(0);
  for (int i = 0; i < 300; ++i) {
    const ProgressMeter step = meter.step(i / 300.0, (i + 1) / 300.0);
    for (int j = 0; j < 7; ++j) step.step(j / 7.0, (j + 1) / 7.0).report(1);
    step.step(0, 0.5).report(0);
  }
  meter.report(1);
  listener.check_whole();
}

namespace {

const Progress nobody;
const ProgressMeter unheard(nobody, "");

void wait_until(const std::atomic<bool>& reached) {
  while (!reached) std::this_thread::yield();
}

/// Calls `check(run)` with both ways to run tasks: `run(count, meter, body)`.
template <class Check>
void for_both(const Check& check) {
  check([](auto&&... arguments) { for_tasks(arguments...); });
  check([](auto&&... arguments) { for_short_tasks(arguments...); });
}

bool many_threads() { return std::thread::hardware_concurrency() > 1; }

}  // namespace

TEST_CASE("tasks: each is done once and progress ends at 1") {
  for_both([](const auto& run) {
    for (const std::size_t count : {0, 1, 7, 1000}) {
      Listener listener;
      const Progress progress = listener.progress();
      std::vector<std::atomic<int>> times(count);
      run(count, ProgressMeter(progress, ""), [&](std::size_t task, const Stopping& stopping) {
        if (!stopping) ++times[task];
      });
      for (const auto& time : times) REQUIRE(time == 1);
      CHECK(std::is_sorted(listener.told.begin(), listener.told.end()));
      if (count > 0) CHECK(listener.told.back() == 1);
    }
  });
}

TEST_CASE("tasks: of several that throw the first one's exception arrives and later ones are not begun") {
  for_both([](const auto& run) {
    for (int round = 0; round < 100; ++round) {
      std::vector<std::atomic<int>> begun(1000);
      const auto body = [&](std::size_t task, const Stopping&) {
        ++begun[task];
        if (task == 100) std::this_thread::sleep_for(std::chrono::microseconds(100));
        if (task >= 100) throw std::runtime_error(std::to_string(task));
      };
      CHECK_THROWS_WITH_AS(run(begun.size(), unheard, body), "100", std::runtime_error);
      for (std::size_t task = 0; task <= 100; ++task) REQUIRE(begun[task] == 1);
      CHECK(begun.back() == 0);
    }
  });
}

TEST_CASE("tasks: an earlier one goes on where a later one throws" * doctest::skip(!many_threads())) {
  std::atomic<bool> second_threw = false;
  bool stopped = true;
  const auto body = [&](std::size_t task, const Stopping& stopping) {
    if (task == 1) {
      second_threw = true;
      throw std::runtime_error("second");
    }
    wait_until(second_threw);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    stopped = bool(stopping);
    throw std::runtime_error("first");
  };
  CHECK_THROWS_WITH_AS(for_tasks(2, unheard, body), "first", std::runtime_error);
  CHECK(!stopped);
}

TEST_CASE("tasks: a later one stops where an earlier one throws" * doctest::skip(!many_threads())) {
  std::atomic<bool> second_begun = false;
  const auto body = [&](std::size_t task, const Stopping& stopping) {
    if (task == 0) {
      wait_until(second_begun);
      throw std::runtime_error("first");
    }
    second_begun = true;
    while (!stopping) std::this_thread::yield();
  };
  CHECK_THROWS_WITH_AS(for_tasks(2, unheard, body), "first", std::runtime_error);
}

TEST_CASE("tasks: cancelling stops those that run and begins no more") {
  std::atomic<bool> begun = false;
  std::atomic<int> count = 0;
  const Progress cancel = [&](double) { return !begun; };
  const auto body = [&](std::size_t, const Stopping& stopping) {
    ++count;
    begun = true;
    while (!stopping) std::this_thread::yield();
    throw std::runtime_error("ignored, as the work was cancelled");
  };
  CHECK_THROWS_AS(for_tasks(1000, ProgressMeter(cancel, "a"), body), Cancelled);
  CHECK(count <= int(std::thread::hardware_concurrency()));

  int short_ones = 0;
  const Progress second = [&](double) { return short_ones < 2; };
  CHECK_THROWS_AS(
      for_short_tasks(1000, ProgressMeter(second, "a"), [&](std::size_t, const Stopping&) { ++short_ones; }),
      Cancelled);
  CHECK(short_ones == 2);
}

}  // namespace swiftgs::test::progress_test
