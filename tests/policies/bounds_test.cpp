// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <set>
#include <utility>

#include <doctest/doctest.h>

#include <swiftgs/swiftgs.hpp>

#include "policies/random_splats.hpp"

namespace swiftgs::test::bounds_test {

namespace {

constexpr int width = 400, height = 300;
const TileGrid grid = TileGrid::covering(width, height);

using Tiles = std::set<std::pair<int, int>>;  // (row, column)

template <class Bounds>
Tiles tiles_of(const SplatShape& shape, TileGrid tiles = grid) {
  Tiles out;
  const auto found = Bounds().tiles(shape, tiles);
  const TileRect& rect = found.rect;
  if (rect.columns.size() == 0) return out;
  for (int row = rect.rows.begin; row < rect.rows.end; ++row) {
    const TileRun run = detail::row_within(found, row);
    for (int column = run.begin; column < run.end; ++column) out.insert({row, column});
  }
  return out;
}

/// Least exponent s, in double, over the pixel centres of one row of one tile.
double least_exponent(const SplatShape& shape, double first_x, double y) {
  const double dy = y - shape.exact_mean().y, q = double(shape.l1) * dy, v = double(shape.l2) * dy;
  // s is smallest where l0 dx + q is nearest to 0: at the pixels next to its root, or at an end.
  const double root = shape.exact_mean().x - q / double(shape.l0) - first_x;
  double least = INFINITY;
  for (const double column : {std::floor(root), std::floor(root) + 1}) {
    const double at = std::min(std::max(column, 0.0), double(raster_block_side - 1));
    const double u = double(shape.l0) * (first_x + at - shape.exact_mean().x) + q;
    least = std::min(least, u * u + v * v);
  }
  return least;
}

/// The tiles in which a pixel centre passes s <= cutoff in double: what no conservative bounds may miss.
Tiles touched_tiles(const SplatShape& shape) {
  Tiles out;
  for (int row = 0; row < grid.rows.end; ++row)
    for (int column = 0; column < grid.columns.end; ++column)
      for (int y = 0; y < raster_block_side && !out.count({row, column}); ++y)
        if (least_exponent(shape, column * raster_block_side + 0.5, row * raster_block_side + y + 0.5) <=
            double(shape.cutoff))
          out.insert({row, column});
  return out;
}

bool contains(const Tiles& all, const Tiles& some) {
  return std::includes(all.begin(), all.end(), some.begin(), some.end());
}

template <class F>
void for_each_conservative(const F& f) {
  for_each_type(AllBounds(), [&]<class Bounds>(Bounds bounds) {
    if constexpr (Bounds::conservative) f(bounds);
  });
}

/// Calls `f` with random splats of every kind, then with hand-made extremes.
template <class F>
void for_each_splat(const F& f) {
  Random random(1);
  for (int i = 0; i < 3000; ++i) f(random_splat(random, width, height));
  for (int i = 0; i < 1000; ++i) f(usual_splat(random, width, height));
  for (const double angle : {0.0, 1e-4, 0.3, 0.785398, 1.5707963, 1.5706, 3.0}) {
    f(make_splat(200, 150, 5478, 0.5478, angle, 1));        // needle of ratio 1e4
    f(make_splat(-3000, 2000, 1e4, 1, angle, 0.3));         // its centre far outside
    f(make_splat(200, 150, 0.5478, 0.5478, angle, 0.004));  // a dot that one pixel keeps at most
    f(make_splat(16, 16, 1e7, 1e6, angle, 1));              // a giant
    f(make_splat(1e6, 150, 1e6, 10, angle, 1));
    f(make_splat(15.5, 15.5, 0.5478, 0.5478, angle, 1.0 / 255));  // cutoff 0, on a pixel centre
  }
}

/// Checks that conservative bounds list the tiles that `needed_by` names for a splat, more than `least` in
/// all.
template <class NeededBy>
void check_tiles(int side, std::size_t least, const NeededBy& needed_by) {
  CAPTURE(side);
  const TileGrid tiles = TileGrid::covering(width, height, side);
  for_each_conservative([&]<class Bounds>(Bounds) {
    CAPTURE(Bounds::name);
    std::size_t missed = 0, needed = 0;
    for_each_splat([&](const SplatShape& shape) {
      const Tiles some = needed_by(shape);
      needed += some.size();
      missed += !contains(tiles_of<Bounds>(shape, tiles), some);
    });
    CHECK(missed == 0);
    CHECK(needed > least);
  });
}

}  // namespace

TEST_CASE("bounds: conservative ones never miss a tile in which a pixel keeps the splat") {
  check_tiles(raster_block_side, 100'000, touched_tiles);
}

TEST_CASE("bounds: conservative ones keep a tile of which one pixel keeps the splat by the last bit") {
  for_each_conservative([&]<class Bounds>(Bounds) {
    CAPTURE(Bounds::name);
    Random random(5);
    int tried = 0, missed = 0;
    for (int i = 0; i < 40'000; ++i) {
      SplatShape shape = i % 2 ? usual_splat(random, width, height) : random_splat(random, width, height);
      const int row = int(random.bits() % std::uint64_t(grid.rows.end));
      const int column = int(random.bits() % std::uint64_t(grid.columns.end));
      double least = INFINITY;
      for (int y = 0; y < raster_block_side; ++y)
        least = std::min(least, least_exponent(shape, column * raster_block_side + 0.5,
                                               row * raster_block_side + y + 0.5));
      if (least > 8) continue;
      // Let the ellipse end at that very pixel, as an opacity of 2^least / 255 would.
      shape.cutoff = std::nextafter(float(least), 9.0f);
      ++tried;
      missed += !tiles_of<Bounds>(shape).count({row, column});
    }
    CHECK(missed == 0);
    CHECK(tried > 4000);
  });
}

TEST_CASE(
    "bounds: conservative ones list every tile of which a rasterizer visits a row of any raster block") {
  // Rounded terms may keep a pixel there that exact ones would not.
  for (const int side : {16, 32, 128})
    check_tiles(side, side == 16 ? 100'000 : 5000, [side](const SplatShape& shape) {
      Tiles rows;
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; x += raster_block_side)
          if (row_touched(shape, float(x) + 0.5f, float(y) + 0.5f)) rows.insert({y / side, x / side});
      return rows;
    });
}

TEST_CASE("bounds: the ellipse lists no tile that the box does not") {
  std::size_t outside = 0;
  for_each_splat([&](const SplatShape& shape) {
    outside += !contains(tiles_of<OpacityBox>(shape), tiles_of<Ellipse>(shape));
  });
  CHECK(outside == 0);
}

TEST_CASE("bounds: the ellipse lists few tiles more than pixels need") {
  // Between centres of pixels an ellipse may slip into a tile without keeping one of its pixels; needles do.
  Random random(2);
  std::size_t listed = 0, needed = 0, boxed = 0;
  for (int i = 0; i < 3000; ++i) {
    const SplatShape shape = usual_splat(random, width, height);
    listed += tiles_of<Ellipse>(shape).size();
    boxed += tiles_of<OpacityBox>(shape).size();
    needed += touched_tiles(shape).size();
  }
  CHECK(double(listed) < 1.02 * double(needed));
  CHECK(double(boxed) > 1.2 * double(needed));
}

TEST_CASE("bounds: an ellipse in one row of tiles is as wide as it is") {
  const SplatShape shape = make_splat(100, 24, 12, 1, 0, 1);
  // ln 255 is 5.541: the ellipse ends sqrt(2 * 5.541) = 3.329 sigmas, or 39.95 pixels, from the centre.
  CHECK(tiles_of<Ellipse>(shape) == Tiles{{1, 3}, {1, 4}, {1, 5}, {1, 6}, {1, 7}, {1, 8}});
  CHECK(tiles_of<Ellipse>(make_splat(100.5, 24, 12, 1, 0, 1)).size() == 6);
}

TEST_CASE("bounds: an ellipse of which the image shows the tip is as wide as the tip") {
  // It ends 6 pixels below the image's upper border, where it is 112 pixels wide; at its centre it is 666.
  const SplatShape shape = make_splat(200, -416, 100, 126.76, 0, 1);
  CHECK(tiles_of<OpacityBox>(shape).size() == std::size_t(grid.columns.size()));
  CHECK(tiles_of<Ellipse>(shape).size() <= 9);
}

TEST_CASE("bounds: a splat off the screen is in no tile") {
  for_each_type(AllBounds(), [&]<class Bounds>(Bounds) {
    CAPTURE(Bounds::name);
    for (const auto& [x, y] : {std::pair{-100.0, 50.0}, {50.0, -100.0}, {600.0, 50.0}, {50.0, 500.0}})
      CHECK(tiles_of<Bounds>(make_splat(x, y, 3, 2, 0.5, 1)).empty());
  });
}

TEST_CASE("bounds: numbers that are not finite stay inside the grid") {
  for_each_type(AllBounds(), [&]<class Bounds>(Bounds) {
    CAPTURE(Bounds::name);
    for (const float wild : {INFINITY, -INFINITY, NAN, 3e38f, -3e38f})
      for (int member = 0; member < 7; ++member) {
        CAPTURE(wild);
        CAPTURE(member);
        SplatShape shape = make_splat(200, 150, 30, 10, 0.4, 0.8);
        float* const members[] = {&shape.mean.x, &shape.mean.y,  &shape.l0,    &shape.l1,
                                  &shape.l2,     &shape.opacity, &shape.cutoff};
        *members[member] = wild;
        for (const auto& [row, column] : tiles_of<Bounds>(shape)) {
          CHECK(row >= 0);
          CHECK(row < grid.rows.end);
          CHECK(column >= 0);
          CHECK(column < grid.columns.end);
        }
      }
  });
}

TEST_CASE("bounds: faint splats get a smaller box") {
  const SplatShape faint = make_splat(200, 150, 30, 30, 0, 0.01), solid = make_splat(200, 150, 30, 30, 0, 1);
  CHECK(tiles_of<OpacityBox>(faint).size() < tiles_of<OpacityBox>(solid).size() / 3);
}

namespace {

/// INRIA's rectangle on tiles of `side` pixels, from its definition: radius ceil(3 sqrt(lambda_max)),
/// coordinates that count from the first pixel's centre.
Tiles inria_tiles(double x, double y, double xx, double xy, double yy, int side) {
  const TileGrid tiles = TileGrid::covering(width, height, side);
  const double mid = 0.5 * (xx + yy);
  const double lambda = mid + std::sqrt(std::max(0.1, mid * mid - (xx * yy - xy * xy)));
  const double radius = std::ceil(3 * std::sqrt(lambda));
  const auto clamp = [](double v, int count) { return int(std::min(std::max(v, 0.0), double(count))); };
  const int left = clamp(std::floor((x - 0.5 - radius) / side), tiles.columns.end);
  const int top = clamp(std::floor((y - 0.5 - radius) / side), tiles.rows.end);
  const int right = clamp(std::floor((x - 0.5 + radius + side - 1) / side), tiles.columns.end);
  const int bottom = clamp(std::floor((y - 0.5 + radius + side - 1) / side), tiles.rows.end);
  Tiles out;
  for (int row = top; row < bottom; ++row)
    for (int column = left; column < right; ++column) out.insert({row, column});
  return out;
}

}  // namespace

TEST_CASE("bounds: the three sigma square is the one of INRIA's rasterizer at any opacity") {
  struct Case {
    double x, y, along, across, angle;
  };
  // The last begins at the border of a tile.
  const Case by_hand[] = {{200, 150, 5, 5, 0},           {200, 150, 40, 2, 0.5}, {3, 4, 7, 7, 0},
                          {399, 299, 10, 1, 1.2},        {-20, 150, 9, 3, 2},    {200, 320, 9, 3, 2.5},
                          {195, 149, 0.5478, 0.5478, 0}, {16.4, 31.9, 2, 2, 0},  {200, 150, 1000, 900, 0.1},
                          {200.5, 152.5, 5, 5, 0},       {208.5, 152.5, 5, 5, 0}};
  for (const Case& c : by_hand)
    for (const int side : {16, 64})
      for (const double opacity : {0.7, 0.01}) {
        CAPTURE(c.x);
        CAPTURE(c.along);
        CAPTURE(side);
        CAPTURE(opacity);
        const double cosine = std::cos(c.angle), sine = std::sin(c.angle);
        const double a = c.along * c.along, b = c.across * c.across;
        const SplatShape shape = make_splat(c.x, c.y, c.along, c.across, c.angle, opacity);
        CHECK(tiles_of<ThreeSigmaSquare>(shape, TileGrid::covering(width, height, side)) ==
              inria_tiles(c.x, c.y, a * cosine * cosine + b * sine * sine, (a - b) * cosine * sine,
                          a * sine * sine + b * cosine * cosine, side));
      }
}

}  // namespace swiftgs::test::bounds_test
