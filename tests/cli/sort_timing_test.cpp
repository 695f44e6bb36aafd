// SPDX-License-Identifier: Apache-2.0
#include "sort_timing.hpp"

#include <map>
#include <set>
#include <string>
#include <vector>

#include <doctest/doctest.h>

using namespace swiftgs;
using namespace swiftgs::cli;

namespace {

/// Takes as long to sort as the width of the image says, times `factor`, and has as many instances.
class ScriptedRenderer final : public AnyRenderer {
 public:
  explicit ScriptedRenderer(double factor) : factor_(factor) {}

  std::string_view name() const override { return "scripted"; }
  std::string device_name() const override { return "none"; }
  void set_scene(std::shared_ptr<const Scene>) override {}
  void set_scene(const SceneArrays&) override {}
  bool share_scene(const AnyRenderer&) override { return true; }
  void render(Span<const Camera> cameras, const RenderSettings&, Span<Frame>) override {
    width_ = cameras[0].width;
  }
  Span<const FrameView> render_resident(Span<const Camera> cameras, const RenderSettings&) override {
    // The first frame after another renderer's is dear.
    first_ = last != this;
    last = this;
    width_ = cameras[0].width, ++frames;
    return {};
  }
  void render_into(Span<const swiftgs::View>, Measures) override {}
  void reserve(Span<const swiftgs::View>, Capacity) override {}
  void set_views(Span<const swiftgs::View>) override {}
  void record(FrameReport*) override {}
  void wait() override {}
  StageTimes times() override {
    turns.push_back(this);
    const double sort = (first_ ? 1000 : 1) * factor_ * width_;
    return {0, sort, 0, sort + 1};
  }
  Statistics statistics() const override { return {0, 0, std::size_t(width_), {}}; }
  StageMemory memory() const override { return {}; }
  void trim() override {}
  void use_calibrations(std::vector<SortCalibration>) override {}
  std::optional<SortCalibration> calibration() const override { return std::nullopt; }
  std::optional<MemoryUse> device_memory() const override { return std::nullopt; }

  int frames = 0;
  static inline const AnyRenderer* last = nullptr;
  static inline std::vector<const AnyRenderer*> turns{};  ///< that were timed

 private:
  double factor_;
  int width_ = 0;
  bool first_ = true;
};

std::vector<cli::View> views_of_widths(const std::vector<int>& widths) {
  std::vector<cli::View> views;
  for (const int width : widths) {
    cli::View view;
    view.camera.width = width, view.camera.height = 1;
    view.name = std::to_string(width);
    views.push_back(view);
  }
  return views;
}

}  // namespace

TEST_CASE("sort timing: a fifth of the views in whole pairs and none of them twice") {
  const std::map<std::size_t, std::size_t> expected{{1, 1},  {2, 2},  {3, 2},    {10, 2},
                                                    {11, 4}, {25, 6}, {100, 20}, {185, 38}};
  for (const auto& [views, count] : expected) {
    const std::vector<std::size_t> chosen = random_fifth(views, 1);
    CHECK(chosen.size() == count);
    CHECK(std::set(chosen.begin(), chosen.end()).size() == count);
    for (const std::size_t number : chosen) CHECK(number < views);
  }
}

TEST_CASE("sort timing: the seed alone decides which views") {
  CHECK(random_fifth(200, 7) == random_fifth(200, 7));
  CHECK(random_fifth(200, 7) != random_fifth(200, 8));
  // Every view has its chance: over many seeds each of 20 comes about as often.
  std::vector<int> times(20);
  for (std::uint64_t seed = 0; seed < 2000; ++seed)
    for (const std::size_t number : random_fifth(20, seed)) ++times[number];
  for (const int count : times) {
    CHECK(count > 320);
    CHECK(count < 480);
  }
}

TEST_CASE("sort timing: each chosen view is sorted by one strategy and neighbours by different ones") {
  ScriptedRenderer standard(2), early(1);
  const std::vector<cli::View> views = views_of_widths({60, 11, 31, 10, 61, 30});
  Progress progress(12);
  std::set<std::string> first_halves;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const SortTimes times = time_sorts(standard, early, views, {}, seed, progress);
    REQUIRE(times.standard.ms.size() == 3);
    REQUIRE(times.early.ms.size() == 3);
    std::set<std::string> all;
    for (std::size_t pair = 0; pair < 3; ++pair) {
      const int a = std::stoi(times.standard.views[pair]), b = std::stoi(times.early.views[pair]);
      CHECK(std::abs(a - b) == 1);
      CHECK(times.standard.ms[pair] == 2 * a);
      CHECK(times.early.ms[pair] == b);
      all.insert({times.standard.views[pair], times.early.views[pair]});
    }
    CHECK(all.size() == 6);
    first_halves.insert(times.standard.views[0] + times.standard.views[1] + times.standard.views[2]);
  }
  CHECK(first_halves.size() > 4);
}

TEST_CASE("sort timing: one view alone is sorted by both strategies") {
  ScriptedRenderer standard(2), early(1);
  Progress progress(3);
  const SortTimes times = time_sorts(standard, early, views_of_widths({50}), {}, 1, progress);
  CHECK(times.standard_ms() == 100);
  CHECK(times.early_ms() == 50);
  CHECK_FALSE(expected_regret(times).has_value());
}

TEST_CASE("sort timing: a frame after another renderer's is not counted") {
  ScriptedRenderer a(1), b(2), c(3);
  Progress progress(2);
  const std::vector<FrameTimes> times =
      time_in_turn({&a, &b, &c}, views_of_widths({10, 20}), {}, 3, progress);
  REQUIRE(times.size() == 3);
  CHECK(times[0].sort == std::vector<double>{10, 20});
  CHECK(times[2].sort == std::vector<double>{30, 60});
  CHECK(times[2].total == std::vector<double>{31, 61});
  CHECK(a.frames >= 8);
}

TEST_CASE("sort timing: renderers take turns in ever new orders") {
  ScriptedRenderer a(1), b(2), c(3);
  Progress progress(20);
  ScriptedRenderer::turns.clear();
  time_in_turn({&a, &b, &c}, views_of_widths(std::vector<int>(20, 8)), {}, 3, progress);
  std::map<const AnyRenderer*, int> times_first;
  const std::vector<const AnyRenderer*>& turns = ScriptedRenderer::turns;
  REQUIRE(turns.size() == 180);
  for (std::size_t round = 0; round < 180; round += 3) {
    ++times_first[turns[round]];
    CHECK(std::set{turns[round], turns[round + 1], turns[round + 2]}.size() == 3);
  }
  for (const AnyRenderer* renderer : {&a, &b, &c}) CHECK(times_first[renderer] > 10);
}

TEST_CASE("sort timing: regret is expected where the strategies are close and the times uncertain") {
  SortTimes times;
  times.standard.ms = {2, 2, 2, 2}, times.early.ms = {1, 1, 1, 1};
  CHECK(expected_regret(times) == 0.0);
  // Differences of 1 and -1 in turn: their mean is 0, its standard error s = sqrt(4 / 3) / 2, and the chance
  // of regret is a half: s / sqrt(2 pi), as a part of the mean of 10.
  times.standard.ms = {10.5, 9.5, 10.5, 9.5}, times.early.ms = {9.5, 10.5, 9.5, 10.5};
  REQUIRE(expected_regret(times));
  CHECK(*expected_regret(times) == doctest::Approx(0.5773502692 * 0.3989422804 / 10));
  // A clear difference leaves next to nothing.
  for (double& ms : times.standard.ms) ms += 5;
  CHECK(*expected_regret(times) < 1e-10);
  CHECK(*expected_regret(times) >= 0);
}

TEST_CASE("sort timing: spread is the standard deviation of a sample") {
  CHECK(mean_of({1, 2, 3, 4}) == 2.5);
  CHECK(spread_of({1, 2, 3, 4}) == doctest::Approx(1.2909944487));
  CHECK(spread_of({7}) == 0);
}
