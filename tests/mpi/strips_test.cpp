// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <tuple>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/mpi/identity.hpp>
#include <swiftgs/mpi/strips.hpp>

#include "support/files.hpp"

using namespace swiftgs;

namespace {

Span<const std::uint64_t> span(const std::vector<std::uint64_t>& v) { return {v.data(), v.size()}; }

/// What each rank takes where row y costs `cost(y)`.
template <class Cost>
std::vector<std::uint64_t> taken(const StripCuts& cuts, const Cost& cost) {
  std::vector<std::uint64_t> times;
  for (std::size_t r = 0; r + 1 < cuts.size(); ++r) {
    std::uint64_t time = 0;
    for (std::uint32_t y = cuts[r]; y < cuts[r + 1]; ++y) time += cost(y);
    times.push_back(time);
  }
  return times;
}

double imbalance(const std::vector<std::uint64_t>& times) {
  return double(*std::max_element(times.begin(), times.end())) * double(times.size()) /
         double(std::accumulate(times.begin(), times.end(), std::uint64_t(0)));
}

}  // namespace

TEST_CASE("mpi strips: all rows are shared out once and none goes without that could have one") {
  for (const std::uint32_t rows : {1u, 2u, 7u, 45u, 158u})
    for (const int ranks : {1, 2, 3, 8, 64}) {
      StripPlan plan(rows, ranks);
      for (int k = 0; k < 5; ++k) {
        const StripCuts& cuts = plan.cuts();
        CHECK(cuts.size() == std::size_t(ranks) + 1);
        CHECK(cuts.front() == 0);
        CHECK(cuts.back() == rows);
        for (std::size_t r = 0; r < std::size_t(ranks); ++r)
          CHECK((r < rows ? cuts[r] < cuts[r + 1] : cuts[r] == cuts[r + 1]));
        // All cost in one row, and none at all.
        plan.learn(span(taken(cuts, [&](std::uint32_t y) { return k % 2 && y == 0 ? 1'000'000'000u : 0u; })));
      }
    }
}

TEST_CASE("mpi strips: they even out whatever rows cost") {
  const auto cost = [](std::uint32_t y) {
    return std::uint64_t(20'000) + (y > 100 ? 900'000 : 0) + 1000 * y;
  };
  for (const int ranks : {2, 3, 4, 8}) {
    StripPlan plan(158, ranks);
    CHECK(imbalance(taken(plan.cuts(), cost)) > 1.3);
    for (int k = 0; k < 30; ++k) plan.learn(span(taken(plan.cuts(), cost)));
    CHECK(imbalance(taken(plan.cuts(), cost)) < 1.15);
  }
}

TEST_CASE("mpi strips: they move where a rank takes a twentieth longer than the mean and else stay") {
  struct Frame {
    std::uint32_t rows;
    std::vector<std::uint64_t> times;
    bool moves;
  };
  for (const Frame& frame : {Frame{40, {1'000'000, 1'020'000, 990'000, 1'010'000}, false},
                             {40, {1'000'000, 1'000'000, 1'000'000, 9'000'000}, true},
                             {400, {1'000'000, 1'000'000, 1'000'000, 1'060'000}, false},
                             {400, {1'000'000, 1'000'000, 1'000'000, 1'080'000}, true}}) {
    StripPlan plan(frame.rows, 4);
    const StripCuts before = plan.cuts();
    plan.learn(span(frame.times));
    CHECK((plan.cuts() != before) == frame.moves);
  }
}

TEST_CASE("mpi strips: rows that cost alike are cut at the nearest row") {
  for (const std::uint32_t rows : {45u, 158u, 1000u})
    for (const int ranks : {2, 3, 7, 16}) {
      CAPTURE(rows);
      CAPTURE(ranks);
      const StripPlan plan(rows, ranks);
      for (int r = 0; r <= ranks; ++r)
        CHECK(std::abs(double(plan.cuts()[std::size_t(r)]) - double(rows) * r / ranks) <= 0.5 + 0.1);
    }
}

TEST_CASE("mpi strips: a strip over several views has the rows of each") {
  std::vector<View> views;
  for (const int height : {40, 33}) {
    const Camera camera = builtin_camera(50, height);
    views.push_back(make_view(camera, Conventions::gsplat(), {.width = 50, .height = height}));
  }
  number_tiles({views.data(), views.size()});
  // Three rows of tiles each, the last of them cut.
  const Strip strip = strip_of({views.data(), views.size()}, 1, 5);
  REQUIRE(strip.view_strips.size() == 2);
  const ViewStrip &first = strip.view_strips[0], &second = strip.view_strips[1];
  CHECK(std::tuple(first.view, first.first_row, first.rows) == std::tuple(0u, 16, 24));
  CHECK(std::tuple(second.view, second.first_row, second.rows) == std::tuple(1u, 0, 32));
  CHECK(strip.views[0].top() == 16);
  CHECK(strip_of({views.data(), views.size()}, 5, 6).view_strips[0].rows == 1);
  CHECK(strip_of({views.data(), views.size()}, 6, 6).view_strips.empty());
}

TEST_CASE("mpi strips: files and views have identities by what they hold") {
  const test::TemporaryFolder folder;
  const std::string large(3 << 20, 'a');
  const auto a = folder.write("a", large), b = folder.write("b", large);
  CHECK(file_identity(a) == file_identity(b));
  std::string longer = large + "a";
  CHECK(file_identity(folder.write("longer", longer)) != file_identity(a));
  std::string last = large;
  last.back() = 'b';
  CHECK(file_identity(folder.write("last", last)) != file_identity(a));
  CHECK(file_identity(folder.write("small", "x")) != file_identity(folder.write("small2", "y")));
  CHECK_THROWS_AS(file_identity(folder / "none"), std::system_error);

  View view = make_view(builtin_camera(50, 40), Conventions::gsplat(), {.width = 50, .height = 40});
  const std::uint64_t identity = views_identity({&view, 1});
  View moved = view;
  moved.camera.centre[1] += 1e-12;
  CHECK(views_identity({&moved, 1}) != identity);
  float memory[2] = {};
  view.frame.features.data = memory, view.frame.feature_channels = 2;
  const std::uint64_t with_features = views_identity({&view, 1});
  CHECK(with_features != identity);
  view.frame.features.data = memory + 1;  // where it is drawn to is each rank's own
  CHECK(views_identity({&view, 1}) == with_features);
  view.frame.feature_channels = 3;
  CHECK(views_identity({&view, 1}) != with_features);
}
