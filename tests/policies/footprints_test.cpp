// SPDX-License-Identifier: Apache-2.0

// Footprints: which tiles a splat may touch, found once and traversed where intersections are emitted,
// whatever the bounds say then.
#include <cstdint>
#include <stdexcept>
#include <string>
#include <type_traits>

#include <doctest/doctest.h>

#include "policies/backends.hpp"
#include "policies/only_targets.hpp"
#include "policies/tile_lists.hpp"

namespace swiftgs::test::footprints_test {

namespace {

/// Checks that `backend` finds the footprints of the scalar bounds, on tiles of every kind of side: in one
/// view, and in two whose splats take turns, of which the second shows a part of its image.
template <class B>
void check_footprints_on(B& backend) {
  for (const std::size_t count : {1, 2})
    for (const int side : {16, 32, 64, 512})
      for_each_type(AllBounds(), [&]<class Bounds>(Bounds bounds) {
        CAPTURE(count);
        CAPTURE(side);
        CAPTURE(Bounds::name);
        const SplatSet set = random_splats(3001, 700, 500, 1 + 2 * count);
        View views[] = {view_without_camera(700, 500, side), view_without_camera(300, 250, side)};
        views[1].grid.columns.begin += 2, views[1].grid.columns.end += 2;
        views[1].grid.rows.begin += 1, views[1].grid.rows.end += 1;
        number_tiles({views, count});
        const auto view_of = [&](std::size_t i) { return count == 1 ? 0 : i / 7 % 2; };
        Splats<B> splats;
        CopySplats<B>::copy(set.view(), splats);
        splats.resize(splats.count, count);
        for (std::size_t i = 0; count == 2 && i < splats.count; ++i)
          splats.of_view.data()[i] = std::uint16_t(view_of(i));
        Footprints<B> footprints;
        bin(backend, plan_without_scene({views, count}), bounds, splats, footprints);
        const FootprintsView found = footprints.view();
        REQUIRE(found.each.size == set.shapes.size());
        CHECK(found.views.tiles == Views(views, count).tiles);
        std::uint64_t intersections = 0, other = 0, in_part = 0;
        for (std::size_t i = 0; i < found.each.size; ++i) {
          const Footprint expected = find_footprint(bounds, set.shapes[i], views[view_of(i)].grid);
          other += found.each[i].mask != expected.mask || found.each[i].count != expected.count ||
                   (expected.count != 0 && found.each[i].first != expected.first);
          intersections += expected.count, in_part += view_of(i) == 1 && expected.count != 0;
        }
        CHECK(other == 0);
        CHECK(found.intersections.most == intersections);
        if (count == 2 && side <= 64) CHECK(in_part > 300);
      });
}

}  // namespace

TEST_CASE("footprints: every backend and every vector target finds those of the scalar bounds") {
  Serial serial;
  check_footprints_on(serial);
  Cpu cpu(4);
  on_each_target([&] { check_footprints_on(cpu); });
}

SWIFTGS_CASE_ON("footprints: those of other splats and that say another number of intersections are refused",
                SWIFTGS_TEST_HOSTS) {
  const SplatSet splats = random_splats(20, 64, 48, 1);
  const Binned<B, Ellipse> binned(backend, splats.job(64, 48), Ellipse{});
  SortJob wrong_sum = binned.job(), wrong_splats = binned.job();
  const std::string sum = std::to_string(wrong_sum.footprints.intersections.most) + " intersections";
  wrong_sum.footprints.intersections = 1;
  const Footprint some[3];
  wrong_splats.footprints.each = {some, 3}, wrong_splats.footprints.intersections = 3;
  for_each_type(AllSorts(), [&]<class Sort>(Sort sort) {
    typename Sort::template Scratch<B> scratch;
    TileLists<B> lists;
    CHECK_THROWS_WITH_AS(sort.build(backend, wrong_sum, Ellipse{}, scratch, lists),
                         doctest::Contains(sum.c_str()), std::invalid_argument);
    CHECK_THROWS_WITH_AS(sort.build(backend, wrong_splats, Ellipse{}, scratch, lists),
                         doctest::Contains("footprints of 3 splats, expected those of 20"),
                         std::invalid_argument);
  });
}

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

    std::uint32_t listed = 0;
    for (std::uint32_t tile = 0; tile < tiles; ++tile) {
      const TileRange range = lists.view().ranges[tile];
      REQUIRE(range.begin <= range.end);
      REQUIRE(range.end <= lists.intersections);
      listed += range.end - range.begin;
    }
    CHECK(listed == lists.intersections);
    CHECK(lists_each(to_vectors(lists.view()), splats.shapes.size(),
                     std::size_t(counted * job.grid.rows.size())));
  };
  for (const int counted : {0, 1, 3, 10})
    for (const int emitted : {0, 1, 3, 10})
      check(EarlySort(), counted, emitted), check(StandardSort(), counted, emitted);
}

}  // namespace swiftgs::test::footprints_test
