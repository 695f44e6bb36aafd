// SPDX-License-Identifier: Apache-2.0

// Emission of `Cpu` with bounds that find other tiles of a large splat than were counted.
#include <algorithm>
#include <cstdint>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/sort/early.hpp>

#include "instances.hpp"
#include "policies/tile_lists.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// Bounds whose rows are `when_counted` columns wide while they are counted and `when_emitted` afterwards.
struct Fickle {
  static constexpr std::string_view name = "fickle";
  static constexpr bool lossless = false;
  static inline int when_counted = 0, when_emitted = 0;
  static inline std::size_t rows_to_count = 0;  ///< calls of `row` that still count

  TileRect rect(const SplatShape&, TileGrid grid) const { return {{0, grid.columns}, {0, grid.rows}}; }
  TileRun row(const SplatShape&, TileRect, int) const {
    const bool counting = rows_to_count > 0;
    if (counting) --rows_to_count;
    return {1, 1 + (counting ? when_counted : when_emitted)};
  }
};

/// All splats are too large for a mask.
void find_footprints(const Fickle&, const SplatShape*, std::size_t count, TileGrid, Footprint* out) {
  for (std::size_t i = 0; i < count; ++i) out[i].mask = 0, out[i].count = to_be_counted;
}

constexpr std::size_t splat_count = 30;

SplatSet some_splats() {
  SplatSet splats;
  for (std::size_t i = 0; i < splat_count; ++i)
    splats.add(make_splat(100, 80, 50, 50, 0, 0.5), float(1 + i % 5));
  return splats;
}

/// Calls f(counted) for bounds that find as many, more and fewer tiles in a row when they emit.
template <class F>
void for_each_disagreement(TileGrid grid, const F& f) {
  for (const int counted : {0, 1, 4, 9})
    for (const int emitted : {0, 1, 4, 9}) {
      CAPTURE(counted);
      CAPTURE(emitted);
      Fickle::when_counted = counted, Fickle::when_emitted = emitted;
      Fickle::rows_to_count = splat_count * std::size_t(grid.rows);
      f(std::size_t(counted * grid.rows));
    }
}

}  // namespace

TEST_CASE("cpu emission: a splat has as many keys as were counted and no two of one tile") {
  const SplatSet splats = some_splats();
  const SortInput job = splats.job(200, 160);
  for_each_disagreement(job.grid, [&](std::size_t counted) {
    Cpu cpu(1);
    InstanceScratch<Cpu> scratch;
    Pairs<Cpu, std::uint64_t> pairs;
    REQUIRE(emit_footprints(cpu, job.within(Fickle{}), Fickle{}, nullptr, scratch, pairs) ==
            splat_count * counted);
    for (std::size_t id = 0; id < splat_count; ++id) {
      std::vector<std::uint64_t> tiles;
      for (std::size_t at = id * counted; at < (id + 1) * counted; ++at) {
        REQUIRE(pairs.values.data()[at] == id);
        tiles.push_back(pairs.keys.data()[at] >> depth_key_bits);
      }
      std::sort(tiles.begin(), tiles.end());
      CHECK(std::adjacent_find(tiles.begin(), tiles.end()) == tiles.end());
      CHECK((tiles.empty() || tiles.back() < job.grid.size()));
    }
  });
}

TEST_CASE("cpu emission: lists have as many instances as were counted and none has a splat twice") {
  const SplatSet splats = some_splats();
  const SortInput job = splats.job(200, 160);
  for_each_disagreement(job.grid, [&](std::size_t counted) {
    Cpu cpu(1);
    GroupScratch<Cpu> scratch;
    TileLists<Cpu> lists;
    group_footprints(cpu, job.within(Fickle{}), Fickle{}, nullptr, scratch, lists);
    REQUIRE(lists.instances == splat_count * counted);
    std::vector<std::size_t> seen(splat_count);
    for (std::vector<std::uint32_t> list : to_vectors(lists.view())) {
      std::sort(list.begin(), list.end());
      CHECK(std::adjacent_find(list.begin(), list.end()) == list.end());
      for (const std::uint32_t id : list) {
        REQUIRE(id < splat_count);
        ++seen[id];
      }
    }
    for (const std::size_t times : seen) CHECK(times == counted);
  });
}

TEST_CASE("cpu emission: a grid of more rows than an image can have is refused") {
  const SplatSet splats = random_splats(20, 64, 48, 1);
  SortInput job = splats.job(64, 48);
  job.grid.rows = 4097;
  Cpu cpu(1);
  CHECK_THROWS_WITH_AS((build_lists<EarlySort, Ellipse>(cpu, job)),
                       "sort: the grid has 4097 rows of tiles, expected at most 4096", std::invalid_argument);
}
