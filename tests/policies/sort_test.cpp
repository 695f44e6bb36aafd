// SPDX-License-Identifier: Apache-2.0

// Tile lists of every sort within every bounds, on every backend.
#include <algorithm>
#include <cstdint>
#include <type_traits>
#include <utility>
#include <vector>

#include "policies/backends.hpp"
#include "policies/tile_lists.hpp"

namespace swiftgs::test::sort_test {

namespace {

/// The three sorts on one backend, with memory that lives from frame to frame.
template <class B>
struct Sorts {
  B backend = test::make_backend<B>();
  StandardSort standard;
  EarlySort early;
  AdaptiveSort adaptive{1};
  StandardSort::Scratch<B> standard_scratch;
  EarlySort::Scratch<B> early_scratch;
  AdaptiveSort::Scratch<B> adaptive_scratch;
  TileLists<B> lists;

  /// Calls f(sort, scratch) for each.
  template <class F>
  void for_each(const F& f) {
    f(standard, standard_scratch), f(early, early_scratch), f(adaptive, adaptive_scratch);
  }

  /// Whether each sort, or `EarlySort` alone, lists `splats` within `Bounds` as brute force does, or as
  /// `Serial` where there are too many tiles for that.
  template <class Bounds>
  HostLists check_within(const SplatSet& splats, int width, int height, bool early_alone = false) {
    CAPTURE(Bounds::name);
    Serial serial;
    const SortInput input = splats.job(width, height);
    const HostLists expected = host_lists(serial, build_lists<StandardSort, Bounds>(serial, input));
    if (splats.shapes.size() * input.grid.size() < 1'000'000)
      CHECK(to_vectors(expected.view()) == brute_force_lists<Bounds>(input));
    const SplatsOn<B> placed(backend, splats);
    const Binned<B, Bounds> binned(backend, placed.job(width, height), Bounds{});
    const auto build = [&](auto& sort, auto& scratch) {
      CAPTURE(sort.name);
      sort.build(backend, binned.job(), Bounds{}, scratch, lists);
      CHECK(host_lists(backend, lists) == expected);
      CHECK(lists.intersections == expected.ids.size());
      CHECK(lists.tiles == input.grid.size());
    };
    if (early_alone)
      build(early, early_scratch);
    else
      for_each(build);
    return expected;
  }
  /// The same within all bounds; with shaders, all sorts within `Ellipse` alone. Returns the intersections of
  /// the last.
  std::size_t check(const SplatSet& splats, int width, int height) {
    std::size_t intersections = 0;
    for_each_type(AllBounds(), [&]<class Bounds>(Bounds) {
      const bool early_alone = has_shaders<B> && !std::is_same_v<Bounds, Ellipse>;
      intersections = check_within<Bounds>(splats, width, height, early_alone).ids.size();
    });
    return intersections;
  }
};

/// A round splat that stays within one tile or so, and one that covers an image of any size.
SplatShape dot(double x, double y) { return make_splat(x, y, 1, 1, 0, 0.9); }
SplatShape giant() { return make_splat(30'000, 30'000, 1e6, 1e6, 0, 1); }

}  // namespace

TEST_CASE_TEMPLATE("sort: every sort takes bounds that the backend has no kernels for", B,
                   SWIFTGS_TEST_HOSTS) {
  Sorts<B>().template check_within<EvenRows>(random_splats(600, 300, 200, 8), 300, 200);
}

SWIFTGS_CONTRACT("sort: every sort within every bounds builds the lists that brute force builds") {
  Sorts<B> sorts;
  SplatSet away;
  away.add(dot(-500, 50), 1);
  // Sizes go up and down: what larger frames left in memory must not show.
  for (const std::size_t n : {20'000, 0, 1, 257, 2, 31, 256, 32, 33, 255, 0, 5'000}) {
    CAPTURE(n);
    sorts.check(random_splats(n, 700, 500, n + 1), 700, 500);
  }
  for (const auto& size :
       {std::pair{300, 200}, {1300, 900}, {16, 16}, {1920, 1080}, {1, 1}, {33, 17}, {1300, 900}}) {
    const int width = size.first, height = size.second;
    CAPTURE(width);
    const SplatSet splats = random_splats(600, width, height, std::uint64_t(width));
    sorts.check(splats, width, height);
    CHECK(sorts.check(away, width, height) == 0);
  }
}

SWIFTGS_CONTRACT("sort: an adaptive sort gives the same bits before and after it decides") {
  const SplatsOn<B> splats(backend, random_splats(5'000, 1000, 700, 2));
  const SortInput job = splats.job(1000, 700);
  const HostLists expected = host_lists(backend, build_lists<StandardSort, Ellipse>(backend, job));
  AdaptiveSort adaptive;
  AdaptiveSort::Scratch<B> scratch;
  TileLists<B> lists;
  for (int frame = 0; frame < 12; ++frame) {
    build_again<Ellipse>(backend, adaptive, job, scratch, lists);
    CHECK(host_lists(backend, lists) == expected);  // waits, so that a device has measured
  }
  CHECK(adaptive.measured().has_value());
}

SWIFTGS_CONTRACT("sort: equal depths keep index order") {
  Sorts<B> sorts;
  SplatSet splats;
  for (int i = 0; i < 5000; ++i) splats.add(dot(8, 8), i % 2 == 0 ? 2.0f : 1.0f);
  const HostLists lists = sorts.template check_within<Ellipse>(splats, 16, 16);
  REQUIRE(lists.ids.size() == 5000);
  bool in_order = true;
  for (std::uint32_t i = 0; i < 2500; ++i)
    in_order = in_order && lists.ids[i] == 2 * i + 1 && lists.ids[2500 + i] == 2 * i;
  CHECK(in_order);
  CHECK(sorts.check(splats, 40, 40) >= 5000);
}

SWIFTGS_CONTRACT("sort: depths are ordered over the whole range of positive floats") {
  SplatSet splats;
  for (const float depth : {3e38f, 1e-45f, 1e10f, 1.0000001f, 1.0f, 1e-38f, 0.01f, 2e-38f})
    splats.add(dot(8, 8), depth);
  CHECK(Sorts<B>().template check_within<OpacityBox>(splats, 16, 16).ids ==
        std::vector<std::uint32_t>{1, 5, 7, 6, 4, 3, 2, 0});
}

SWIFTGS_CONTRACT("sort: more than 65536 tiles are told apart") {
  Sorts<B> sorts;
  const int columns = 300, rows = 299;
  SplatSet splats;
  for (int i = 0; i < columns * rows; ++i)
    splats.add(dot(16 * (i % columns) + 8, 16 * (i / columns) + 8), 1.0f + float(i % 7));
  const HostLists lists = sorts.template check_within<Ellipse>(splats, 16 * columns, 16 * rows);
  REQUIRE(lists.ids.size() == 89'700);
  bool each_at_home = true;
  for (std::uint32_t i = 0; i < 89'700; ++i)
    each_at_home = each_at_home && lists.ranges[i].end == lists.ranges[i].begin + 1 &&
                   lists.ids[lists.ranges[i].begin] == i;
  CHECK(each_at_home);

  SplatSet few = random_splats(300, 4300, 4300, 6);
  few.add(giant(), 1.5f), few.add(giant(), 0.5f);
  CHECK(sorts.check(few, 4300, 4300) > 2 * 269 * 269);
  CHECK(sorts.check(random_splats(300, max_image_side, 64, 7), max_image_side, 64) > 300);
  CHECK(sorts.check(random_splats(300, 64, max_image_side, 8), 64, max_image_side) > 300);
}

SWIFTGS_CASE_ON("sort: a few splats are spread over the largest image by every bit of their keys",
                SWIFTGS_TEST_HOSTS) {
  Random random(9);
  SplatSet splats;
  for (int i = 0; i < 2000; ++i)
    splats.add(dot(random.in(0, max_image_side), random.in(0, max_image_side)),
               float(random.scale(1e-38, 1e38)));
  for (int i = 0; i < 200; ++i) splats.add(dot(65'000, 65'000), float(random.scale(1e-38, 1e38)));
  const SortInput job = splats.job(max_image_side, max_image_side);
  const HostLists expected = host_lists(backend, build_lists<EarlySort, OpacityBox>(backend, job));
  bool ordered = true;
  std::size_t listed = 0;
  for (const TileRange& range : expected.ranges) {
    const std::uint32_t* ids = expected.ids.data();
    listed += range.end - range.begin;
    ordered =
        ordered && std::is_sorted(ids + range.begin, ids + range.end, [&](std::uint32_t a, std::uint32_t b) {
          return splats.depths[a] < splats.depths[b];
        });
  }
  CHECK(ordered);
  CHECK(listed == expected.ids.size());
  CHECK(listed >= 2200);
  CHECK(host_lists(backend, build_lists<StandardSort, OpacityBox>(backend, job)) == expected);
}

SWIFTGS_CONTRACT("sort: splats larger than the screen are in every tile, also among dots") {
  Sorts<B> sorts;
  SplatSet two;
  two.add(make_splat(70, 40, 1e6, 1e5, 0.4, 1), 1);
  two.add(make_splat(-900, -900, 4000, 4000, 0, 1), 1);
  CHECK(to_vectors(sorts.template check_within<Ellipse>(two, 150, 90).view()) == Lists(60, {0, 1}));
  for (const int at : {0, 1, 31, 32, 500, 999}) {
    CAPTURE(at);
    SplatSet splats = random_splats(1000, 1000, 700, 4);
    splats.shapes[std::size_t(at)] = giant();
    CHECK(sorts.check(splats, 1000, 700) > 63 * 44);
  }
  SplatSet giants;
  for (int i = 0; i < 100; ++i) giants.add(giant(), 1.0f + float(i % 3));
  CHECK(sorts.check(giants, 1000, 700) == 100 * 63 * 44);
}

SWIFTGS_CONTRACT("sort: more intersections than there can be are refused before memory is taken") {
  Sorts<B> sorts;
  // The largest image has 2^24 tiles: 129 splats that fill it are 2^24 intersections too many.
  SplatSet splats;
  for (int i = 0; i < 129; ++i) splats.add(giant(), 1);
  const SplatsOn<B> placed(sorts.backend, splats);
  const SortInput job = placed.job(max_image_side, max_image_side);
  REQUIRE(job.grid.size() == std::size_t(1) << 24);
  sorts.for_each([&](auto& sort, auto& scratch) {
    CAPTURE(sort.name);
    CHECK_THROWS_WITH_AS(build_again<OpacityBox>(sorts.backend, sort, job, scratch, sorts.lists),
                         "intersections in one frame: 2164260864 needed, the limit is 2147483648",
                         CapacityError);
    CHECK(sorts.lists.ids.capacity() == 0);
  });
  sorts.check(random_splats(50, 60, 40, 7), 60, 40);
}

TEST_CASE("grid: key bits are as few as tell all tiles apart") {
  CHECK(FrameTiles{1, 1}.key_bits() == 0);
  CHECK(FrameTiles{2, 1}.key_bits() == 1);
  CHECK(FrameTiles{3, 1}.key_bits() == 2);
  CHECK(FrameTiles{16, 16}.key_bits() == 8);
  CHECK(FrameTiles{257, 1}.key_bits() == 9);
  CHECK(FrameTiles{4096, 4096}.key_bits() == 24);
  CHECK(TileGrid::covering(1, 17).size() == 2);
}

TEST_CASE("sort: the key of a frame holds the height of all views and their number") {
  const Scene scene = random_scene(10, 0, 1);
  const auto key = [&](std::size_t count, int width, int height) {
    const std::vector<View> views(count, view_without_camera(width, height));
    return FrameKey::of(view(scene), span_of(views));
  };
  const FrameKey tall = key(max_views, 3, max_image_side);
  CHECK(tall.height == std::int64_t(1) << 32);
  CHECK(tall.width == 3);
  CHECK(tall.views == max_views);
  CHECK(tall.gaussians == 10);
  CHECK(key(max_views / 2, 3, max_image_side).height == std::int64_t(1) << 31);
  CHECK_FALSE(key(2, 40, 30) == key(1, 40, 60));
  CHECK(key(2, 40, 30) == key(2, 40, 30));
}

}  // namespace swiftgs::test::sort_test
