// SPDX-License-Identifier: Apache-2.0
#include "policies/backends.hpp"
#include "policies/tile_lists.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// Calls `f` with one object of each sort.
template <class F>
void for_each_sort(const F& f) {
  for_each_type(AllSorts(), f);
}

/// Calls `f` with one object of each kind of bounds.
template <class F>
void for_each_bounds(const F& f) {
  for_each_type(AllBounds(), f);
}

template <class B>
bool same_bits(const TileLists<B>& a, const TileLists<B>& b) {
  const TileListsView va = a.view(), vb = b.view();
  const auto same = [](TileRange x, TileRange y) { return x.begin == y.begin && x.end == y.end; };
  return va.ids.size == vb.ids.size && va.ranges.size == vb.ranges.size &&
         std::equal(va.ids.begin(), va.ids.end(), vb.ids.begin()) &&
         std::equal(va.ranges.begin(), va.ranges.end(), vb.ranges.begin(), same);
}

/// A round splat that stays within one tile or so.
SplatShape dot(double x, double y) { return make_splat(x, y, 1, 1, 0, 0.9); }

/// Bounds that no backend knows: the even rows of the box.
struct EvenRows {
  static constexpr std::string_view name = "even-rows";
  static constexpr bool conservative = false;
  struct Tiles {
    TileRect rect;
    TileRun row(int row) const { return row % 2 ? TileRun{} : rect.columns; }
  };
  Tiles tiles(const SplatShape& shape, TileGrid grid) const { return {opacity_box(shape, grid)}; }
};

}  // namespace

TEST_CASE_TEMPLATE("sort: every sort takes bounds that the backend has no kernels for", B,
                   SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  const SplatSet splats = random_splats(600, 300, 200, 8);
  const SortInput job = splats.job(300, 200);
  const Lists expected = brute_force_lists<EvenRows>(job);
  for_each_sort([&]<class Sort>(Sort) {
    CAPTURE(Sort::name);
    CHECK(to_vectors(build_lists<Sort, EvenRows>(backend, job).view()) == expected);
  });
}

TEST_CASE_TEMPLATE("sort: every sort with every bounds builds the lists that brute force builds", B,
                   SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  const SplatSet splats = random_splats(600, 300, 200, 1);
  const SortInput job = splats.job(300, 200);
  for_each_bounds([&]<class Bounds>(Bounds) {
    CAPTURE(Bounds::name);
    const Lists expected = brute_force_lists<Bounds>(job);
    for_each_sort([&]<class Sort>(Sort) {
      CAPTURE(Sort::name);
      const TileLists<B> lists = build_lists<Sort, Bounds>(backend, job);
      CHECK(lists.tiles == job.grid.size());
      CHECK(to_vectors(lists.view()) == expected);
      std::size_t intersections = 0;
      for (const auto& list : expected) intersections += list.size();
      CHECK(lists.intersections == intersections);
    });
  });
}

TEST_CASE_TEMPLATE("sort: the three sorts give the same bits", B, SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  const SplatSet splats = random_splats(5'000, 1000, 700, 2);
  const SortInput job = splats.job(1000, 700);
  for_each_bounds([&]<class Bounds>(Bounds) {
    CAPTURE(Bounds::name);
    const TileLists<B> standard = build_lists<StandardSort, Bounds>(backend, job);
    CHECK(standard.intersections > 50'000);
    CHECK(same_bits(standard, build_lists<EarlySort, Bounds>(backend, job)));
    // An adaptive sort runs one sort in its first frame and the other in the next.
    AdaptiveSort adaptive;
    AdaptiveSort::Scratch<B> scratch;
    TileLists<B> lists;
    for (int frame = 0; frame < 12; ++frame) {
      build_again<Bounds>(backend, adaptive, job, scratch, lists);
      CHECK(same_bits(standard, lists));
    }
    CHECK(adaptive.calibration().has_value());
  });
}

TEST_CASE("sort: both backends give the same bits on 1 2 4 and 8 threads") {
  const SplatSet splats = random_splats(5'000, 1000, 700, 3);
  const SortInput job = splats.job(1000, 700);
  Serial serial;
  const TileLists<Serial> expected = build_lists<StandardSort, Ellipse>(serial, job);
  const std::vector<std::uint32_t> ids(expected.view().ids.begin(), expected.view().ids.end());
  for (const int threads : {1, 2, 4, 8}) {
    CAPTURE(threads);
    Cpu cpu(threads);
    for_each_sort([&]<class Sort>(Sort) {
      CAPTURE(Sort::name);
      const TileLists<Cpu> lists = build_lists<Sort, Ellipse>(cpu, job);
      CHECK(std::vector<std::uint32_t>(lists.view().ids.begin(), lists.view().ids.end()) == ids);
    });
  }
}

TEST_CASE_TEMPLATE("sort: equal depths keep index order", B, SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  SplatSet splats;
  for (int i = 0; i < 5000; ++i) splats.add(dot(8, 8), i % 2 == 0 ? 2.0f : 1.0f);
  for_each_sort([&]<class Sort>(Sort) {
    CAPTURE(Sort::name);
    const TileLists<B> lists = build_lists<Sort, Ellipse>(backend, splats.job(16, 16));
    REQUIRE(lists.intersections == 5000);
    bool in_order = true;
    for (std::uint32_t i = 0; i < 2500; ++i) {
      in_order = in_order && lists.ids.data()[i] == 2 * i + 1;
      in_order = in_order && lists.ids.data()[2500 + i] == 2 * i;
    }
    CHECK(in_order);
  });
}

TEST_CASE_TEMPLATE("sort: depths are ordered over the whole range of positive floats", B,
                   SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  SplatSet splats;
  for (const float depth : {3e38f, 1e-45f, 1e10f, 1.0000001f, 1.0f, 1e-38f, 0.01f, 2e-38f})
    splats.add(dot(8, 8), depth);
  for_each_sort([&]<class Sort>(Sort) {
    CAPTURE(Sort::name);
    const TileLists<B> lists = build_lists<Sort, OpacityBox>(backend, splats.job(16, 16));
    CHECK(to_vectors(lists.view())[0] == std::vector<std::uint32_t>{1, 5, 7, 6, 4, 3, 2, 0});
  });
}

TEST_CASE_TEMPLATE("sort: more than 65536 tiles are told apart", B, SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  const int columns = 300, rows = 299;
  SplatSet splats;
  for (int i = 0; i < columns * rows; ++i)
    splats.add(dot(16 * (i % columns) + 8, 16 * (i / columns) + 8), 1.0f + float(i % 7));
  const SortInput job = splats.job(16 * columns, 16 * rows);
  REQUIRE(job.grid.size() == 89'700);
  CHECK(FrameTiles{std::uint32_t(columns), std::uint32_t(rows)}.key_bits() == 17);
  for_each_sort([&]<class Sort>(Sort) {
    CAPTURE(Sort::name);
    const TileLists<B> lists = build_lists<Sort, Ellipse>(backend, job);
    CHECK(lists.intersections == 89'700);
    bool each_at_home = true;
    for (std::uint32_t i = 0; i < 89'700; ++i) {
      const TileRange range = lists.ranges.data()[i];
      each_at_home = each_at_home && range.end == range.begin + 1 && lists.ids.data()[range.begin] == i;
    }
    CHECK(each_at_home);
  });
}

TEST_CASE_TEMPLATE("sort: a few splats are spread over the largest image by every bit of their keys", B,
                   SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  Random random(9);
  SplatSet splats;
  for (int i = 0; i < 2000; ++i)
    splats.add(dot(random.in(0, max_image_side), random.in(0, max_image_side)),
               float(random.scale(1e-38, 1e38)));
  for (int i = 0; i < 200; ++i) splats.add(dot(65'000, 65'000), float(random.scale(1e-38, 1e38)));
  const SortInput job = splats.job(max_image_side, max_image_side);
  const TileLists<B> expected = build_lists<EarlySort, OpacityBox>(backend, job);
  bool ordered = true;
  std::size_t listed = 0;
  for (const TileRange& range : expected.view().ranges) {
    const std::uint32_t* ids = expected.view().ids.data;
    listed += range.end - range.begin;
    ordered =
        ordered && std::is_sorted(ids + range.begin, ids + range.end, [&](std::uint32_t a, std::uint32_t b) {
          return splats.depths[a] < splats.depths[b];
        });
  }
  CHECK(ordered);
  CHECK(listed == expected.intersections);
  CHECK(listed >= 2200);
  CHECK(same_bits(expected, build_lists<StandardSort, OpacityBox>(backend, job)));
}

TEST_CASE_TEMPLATE("sort: a splat larger than the screen is in every tile", B, SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  SplatSet splats;
  splats.add(make_splat(70, 40, 1e6, 1e5, 0.4, 1), 1);
  splats.add(make_splat(-900, -900, 4000, 4000, 0, 1), 1);
  for_each_bounds([&]<class Bounds>(Bounds) {
    for_each_sort([&]<class Sort>(Sort) {
      CAPTURE(Sort::name);
      CAPTURE(Bounds::name);
      const Lists lists = to_vectors(build_lists<Sort, Bounds>(backend, splats.job(150, 90)).view());
      CHECK(lists == Lists(60, {0, 1}));
    });
  });
}

TEST_CASE_TEMPLATE("sort: no splats give empty lists in every tile whatever was there before", B,
                   SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  SplatSet none, away, some = random_splats(100, 100, 100, 4);
  away.add(dot(-500, 50), 1);
  for_each_sort([&]<class Sort>(Sort sort) {
    CAPTURE(Sort::name);
    typename Sort::template Scratch<B> scratch;
    TileLists<B> lists;
    build_again<Ellipse>(backend, sort, some.job(100, 100), scratch, lists);
    CHECK(lists.intersections > 0);
    for (const SplatSet* set : {&none, &away}) {
      build_again<Ellipse>(backend, sort, set->job(100, 100), scratch, lists);
      CHECK(lists.intersections == 0);
      CHECK(to_vectors(lists.view()) == Lists(49));
    }
  });
}

TEST_CASE_TEMPLATE("sort: memory of earlier frames does not show in a smaller frame", B,
                   SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  const SplatSet large = random_splats(3000, 400, 300, 5), small = random_splats(50, 60, 40, 6);
  for_each_sort([&]<class Sort>(Sort sort) {
    CAPTURE(Sort::name);
    typename Sort::template Scratch<B> scratch;
    TileLists<B> lists;
    build_again<Ellipse>(backend, sort, large.job(400, 300), scratch, lists);
    build_again<Ellipse>(backend, sort, small.job(60, 40), scratch, lists);
    CHECK(to_vectors(lists.view()) == brute_force_lists<Ellipse>(small.job(60, 40)));
  });
}

TEST_CASE_TEMPLATE("sort: more intersections than there can be are refused before memory is taken", B,
                   SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  // The largest image has 2^24 tiles: 129 splats that fill it are 2^24 intersections too many.
  SplatSet splats;
  for (int i = 0; i < 129; ++i) splats.add(make_splat(32'768, 32'768, 1e6, 1e6, 0, 1), 1);
  const SortInput job = splats.job(max_image_side, max_image_side);
  REQUIRE(job.grid.size() == std::size_t(1) << 24);
  const SplatSet small = random_splats(50, 60, 40, 7);
  for_each_sort([&]<class Sort>(Sort sort) {
    CAPTURE(Sort::name);
    typename Sort::template Scratch<B> scratch;
    TileLists<B> lists;
    CHECK_THROWS_WITH_AS(build_again<OpacityBox>(backend, sort, job, scratch, lists),
                         "intersections in one frame: 2164260864 needed, the limit is 2147483648",
                         CapacityError);
    CHECK(lists.ids.capacity() == 0);
    build_again<OpacityBox>(backend, sort, small.job(60, 40), scratch, lists);
    CHECK(to_vectors(lists.view()) == brute_force_lists<OpacityBox>(small.job(60, 40)));
  });
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
    return FrameKey::of(view(scene), {views.data(), views.size()});
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
