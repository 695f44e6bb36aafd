// SPDX-License-Identifier: Apache-2.0
#include <cstdint>
#include <type_traits>
#include <vector>

#include <doctest/doctest.h>

#include "policies/backends.hpp"
#include "policies/tile_lists.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// Bounds whose rows are `when_counted` columns wide while they are counted and `when_emitted` afterwards, as
/// a compiler may make of rounding that it is free to choose.
struct Fickle {
  static constexpr std::string_view name = "fickle";
  static constexpr bool conservative = false;
  static inline int when_counted = 0, when_emitted = 0;
  static inline std::size_t rows_to_count = 0;  ///< calls of `row` that still count

  struct Tiles {
    TileRect rect;
    TileRun row(int) const {
      const bool counting = rows_to_count > 0;
      if (counting) --rows_to_count;
      const int width = counting ? when_counted : when_emitted;
      return {0, width < rect.columns.end ? width : rect.columns.end};
    }
  };
  Tiles tiles(const SplatShape&, TileGrid grid) const { return {{grid.columns, grid.rows}}; }
};

}  // namespace

TEST_CASE_TEMPLATE(
    "sort: emission fills what was counted whatever the bounds say then and no list names a splat twice", B,
    Serial, Cpu) {
  SplatSet splats;
  for (int i = 0; i < 20; ++i) splats.add(make_splat(40, 24, 2, 2, 0, 0.5), float(1 + i % 5));
  const SortInput job = splats.job(160, 48);  // ten columns: too many for a mask
  const auto tiles = std::uint32_t(job.grid.size());
  const auto check = [&]<class Sort>(Sort sort, int counted, int emitted) {
    CAPTURE(Sort::name);
    CAPTURE(counted);
    CAPTURE(emitted);
    Fickle::when_counted = counted, Fickle::when_emitted = emitted;
    Fickle::rows_to_count = 20 * std::size_t(job.grid.rows.size());
    B backend;
    if constexpr (std::is_same_v<B, Cpu>) backend = Cpu(1);  // `Fickle` counts calls
    typename Sort::template Scratch<B> scratch;
    TileLists<B> lists;
    build_again<Fickle>(backend, sort, job, scratch, lists);
    CHECK(lists.intersections == std::size_t(20 * counted * job.grid.rows.size()));

    // Every list holds splats that there are, none of them twice, and each is listed as often as it was
    // counted.
    std::vector<std::size_t> seen(splats.shapes.size());
    std::uint32_t listed = 0;
    for (std::uint32_t tile = 0; tile < tiles; ++tile) {
      const TileRange range = lists.view().ranges[tile];
      REQUIRE(range.begin <= range.end);
      REQUIRE(range.end <= lists.intersections);
      listed += range.end - range.begin;
      const std::vector<std::size_t> before = seen;
      for (std::uint32_t at = range.begin; at < range.end; ++at) {
        REQUIRE(lists.view().ids[at] < splats.shapes.size());
        ++seen[lists.view().ids[at]];
      }
      for (std::size_t id = 0; id < seen.size(); ++id) CHECK(seen[id] <= before[id] + 1);
    }
    CHECK(listed == lists.intersections);
    for (const std::size_t times : seen) CHECK(times == std::size_t(counted * job.grid.rows.size()));
  };
  for (const int counted : {0, 1, 3, 10})
    for (const int emitted : {0, 1, 3, 10})
      check(EarlySort(), counted, emitted), check(StandardSort(), counted, emitted);
}
