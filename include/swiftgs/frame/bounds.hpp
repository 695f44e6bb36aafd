// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <tuple>
#include <utility>

#include <swiftgs/frame/span.hpp>
#include <swiftgs/frame/splats.hpp>
#include <swiftgs/frame/tiles.hpp>
#include <swiftgs/frame/views.hpp>

namespace swiftgs {

/// Columns and rows of tiles.
struct TileRect {
  TileRun columns, rows;
  bool full = false;  ///< each row is known to have all columns

  SWIFTGS_HD TileRect within(const TileGrid& grid) const {
    return {columns.within(grid.columns), rows.within(grid.rows), full};
  }
};

/// Tiles that a splat may touch where each row has all columns. Bounds whose rows differ have a type of
/// their own, which holds what is computed once a splat.
struct BoxTiles {
  TileRect rect;

  SWIFTGS_HD TileRun row(int) const { return rect.columns; }
};

/// Policy: which tiles a splat may touch. `tiles` finds the box of those tiles, `rect`, and prepares what its
/// rows need; `row` then finds the run of columns in one row of the box. An ellipse meets a row of tiles in
/// one run, so one evaluation per row replaces a test per tile; a `full` box needs none. Conservative bounds
/// include every tile in which a pixel keeps the splat, and every tile that the test of a warp block accepts:
/// the ellipse s <= 1.0001 cutoff meets the box of its 8x8 pixel centres, 2^-8 pixels wider on each side.
/// Devices cut long lists into segments of such splats. A splat between two rows of pixel centres is listed
/// nowhere.
template <class P>
concept BoundsPolicy = requires(const P bounds, const SplatShape& shape, TileGrid grid, int row) {
  { P::name } -> std::convertible_to<std::string_view>;
  { P::conservative } -> std::convertible_to<bool>;
  { bounds.tiles(shape, grid).rect } -> std::convertible_to<TileRect>;
  { bounds.tiles(shape, grid).row(row) } -> std::same_as<TileRun>;
};

/// What `Bounds` know of one splat.
template <class Bounds>
using TilesWithin = decltype(std::declval<const Bounds&>().tiles(SplatShape(), TileGrid()));

/// The tiles from `begin` to `end`. Both are rounded down, and limited to what an integer holds.
SWIFTGS_HD inline TileRun tile_run(float begin, float end) {
#if defined(__CUDA_ARCH__)
  return {__float2int_rd(begin), __float2int_rd(end)};
#else
  const auto limited = [](float v) {
    constexpr float most = 0x1p30f;
    return int(std::floor(v >= -most ? (v < most ? v : most) : -most));
  };
  return {limited(begin), limited(end)};
#endif
}

/// 1 / side of a tile: exact and without a division, since of a power of two only the exponent changes sign.
SWIFTGS_HD inline float inverse_of(int side) {
  return __builtin_bit_cast(float, 0x7f000000u - __builtin_bit_cast(std::uint32_t, float(side)));
}

/// Tiles that hold a pixel centre in [low, high] @units{pixels}. They may lie outside of the image.
SWIFTGS_HD inline TileRun tiles_between(float low, float high, int side) {
  const float inverse_side = inverse_of(side);
  // The first centre at or above `low` is ceil(low - 0.5) + 0.5, the last at or below `high` is floor(high -
  // 0.5) + 0.5.
  const float first = std::ceil(low - 0.5f), last = std::floor(high - 0.5f);
  if (!(first <= last && last >= 0)) return {};
  return tile_run(first * inverse_side, last * inverse_side + 1);
}

/// Tiles whose span from first to last pixel centre meets [low, high] @units{pixels}. For columns:
/// a rasterizer visits the rows of pixels in which the span meets the ellipse, and rounding may keep a centre
/// there although the ellipse passes between two.
SWIFTGS_HD inline TileRun tiles_meeting(float low, float high, int side) {
  const float inverse_side = inverse_of(side);
  const float first = std::ceil((low - (float(side) - 0.5f)) * inverse_side);
  const float last = std::floor((high - 0.5f) * inverse_side);
  return tile_run(first, last + 1);
}

/// How much a conservative bound is widened, so that rounding never cuts a pixel that a rasterizer keeps.
/// Near column 65,536 a hundredth covers 2^-8 that `mean` lacks and two roundings of 2^-9. @units{pixels}
SWIFTGS_HD inline float bounds_slack(float half_width, float half_height) {
  return 1e-2f + 1e-4f * (half_width + half_height);
}

/// Half the width and the height of the ellipse s <= cutoff, and `bounds_slack`. @units{pixels}
struct EllipseExtent {
  float width, height, slack;

  /// No square leaves the range of float where the variances do not.
  SWIFTGS_HD explicit EllipseExtent(const SplatShape& shape) {
    const float inverse_l0 = near_inverse(shape.l0), inverse_l2 = near_inverse(shape.l2);
    const float tilt = shape.l1 * inverse_l0 * inverse_l2, root = near_sqrt(shape.cutoff);
    width = root * near_sqrt(inverse_l0 * inverse_l0 + tilt * tilt), height = root * inverse_l2;
    slack = bounds_slack(width, height);
  }
};

/// Tiles that the box of the ellipse s <= cutoff touches, in the image and outside. `half` is its extent.
SWIFTGS_HD inline TileRect opacity_box(const SplatShape& shape, const EllipseExtent& half, int side) {
  const float x = half.width + half.slack, y = half.height + half.slack;
  return {tiles_meeting(shape.mean.x - x, shape.mean.x + x, side),
          tiles_between(shape.mean.y - y, shape.mean.y + y, side)};
}

/// The same within a grid, for bounds that find fewer tiles in some rows. Convex ones miss next to nothing of
/// a box of a single row or column: it is `full`. So it is in each part of an image.
SWIFTGS_HD inline TileRect convex_box(const SplatShape& shape, const EllipseExtent& half,
                                      const TileGrid& grid) {
  TileRect box = opacity_box(shape, half, grid.side);
  box.full = box.columns.is_one() || box.rows.is_one();
  return box.within(grid);
}

/// The tiles that a splat may touch, found once. Emission expands them to tile intersections: one entry per
/// splat and tile.
struct alignas(16) Footprint {
  /// Side of the mask in tiles.
  static constexpr int side = 8;

  std::uint64_t mask = 0;   ///< bit 8 r + c: the tile r rows below and c columns right of the first; zero
                            ///< where the splat spans more than 8 tiles a side, or touches none
  std::uint32_t count = 0;  ///< of tiles
  std::uint32_t first = 0;  ///< number of the first tile
};
static_assert(sizeof(Footprint) == 16);

/// The tiles of each splat of a frame. Holds for the bounds that found them and for these views alone.
struct FootprintsView {
  Span<const Footprint> each{};  ///< @shape{splats}
  Count intersections;           ///< sum of their counts
  Views views;
  const std::uint64_t* overflowed = nullptr;  ///< not 0: they exceed the capacity; null: they fit
};

/// Storage of one frame's footprints on backend `B`.
template <class B>
struct Footprints {
  typename B::template Buffer<Footprint> each;
  std::size_t count = 0;  ///< splats
  std::uint64_t intersections = 0;
  Views views;

  FootprintsView view() const { return {{each.data(), count}, std::size_t(intersections), views}; }
  void reserve(B&, const Reservation& reserved) { each.reset_exactly(reserved.capacity.splats); }
  static auto buffers(auto& self) { return std::tie(self.each); }
};

namespace detail {
SWIFTGS_HD inline unsigned lowest_bit(std::uint64_t mask) {
#if defined(__CUDA_ARCH__)
  return unsigned(__ffsll(static_cast<long long>(mask))) - 1;
#else
  return unsigned(std::countr_zero(mask));
#endif
}

/// Mask of all tiles of a box of 1 to 8 rows and columns.
SWIFTGS_HD inline std::uint64_t full_mask(const TileRect& rect) {
  constexpr std::uint64_t column = 0x0101010101010101;
  const std::uint64_t row = (1u << rect.columns.size()) - 1;
  return row * (column >> Footprint::side * (Footprint::side - rect.rows.size()));
}

/// Calls f(tile) for the tiles of a footprint's mask, in rows of `stride` tiles.
template <class F>
SWIFTGS_HD void for_each_masked_tile(const Footprint& footprint, std::uint32_t stride, const F& f) {
  for (std::uint64_t mask = footprint.mask; mask != 0; mask &= mask - 1) {
    const unsigned bit = lowest_bit(mask);
    f(footprint.first + bit / Footprint::side * stride + bit % Footprint::side);
  }
}

/// The run of `tiles` in one row of their rectangle, and nothing outside of it.
template <class Tiles>
SWIFTGS_HD TileRun row_within(const Tiles& tiles, int row) {
  const TileRun columns = tiles.rect.columns;
  if (tiles.rect.full) return columns;
  const TileRun run = tiles.row(row);
  return {run.begin > columns.begin ? run.begin : columns.begin,
          run.end < columns.end ? run.end : columns.end};
}
}  // namespace detail

/// Footprint of `shape` within `bounds`, on the grid of its view.
template <BoundsPolicy Bounds>
SWIFTGS_HD Footprint find_footprint(const Bounds& bounds, const SplatShape& shape, TileGrid grid) {
  const auto tiles = bounds.tiles(shape, grid);
  const TileRect& rect = tiles.rect;
  if (rect.columns.size() == 0 || rect.rows.size() == 0) return {};
  Footprint footprint;
  footprint.first = grid.number(rect.columns.begin, rect.rows.begin);
  const bool fits = rect.columns.size() <= Footprint::side && rect.rows.size() <= Footprint::side;
  for (int row = rect.rows.begin; row < rect.rows.end; ++row) {
    const TileRun run = detail::row_within(tiles, row);
    footprint.count += std::uint32_t(run.size());
    if (fits && run.size() > 0)
      footprint.mask |= ((std::uint64_t(1) << run.size()) - 1)
                        << (Footprint::side * (row - rect.rows.begin) + run.begin - rect.columns.begin);
  }
  return footprint;
}

/// Calls f(tile) for the tiles of a splat with this footprint, `footprint.count` times, each tile once.
///
/// A splat too large for a mask evaluates its bounds again, and the compiler may round differently here than
/// where tiles were counted. Surplus tiles are left out. Missing ones are replaced by other tiles of the
/// grid, in which the splat shows nothing.
template <BoundsPolicy Bounds, class F>
SWIFTGS_HD void for_each_tile(const Footprint& footprint, const Bounds& bounds, const SplatShape& shape,
                              TileGrid grid, const F& f) {
  detail::for_each_masked_tile(footprint, grid.stride, f);
  if (footprint.mask != 0 || footprint.count == 0) return;

  std::uint32_t left = footprint.count;
  const auto tiles = bounds.tiles(shape, grid);
  const TileRect& rect = tiles.rect;
  for (const bool inside : {true, false}) {
    const TileRun rows = inside ? rect.rows : grid.rows;
    for (int row = rows.begin; row < rows.end && left != 0; ++row) {
      TileRun run;
      if (row >= rect.rows.begin && row < rect.rows.end) run = detail::row_within(tiles, row);
      const TileRun traversed = inside ? run : grid.columns;
      for (int column = traversed.begin; column < traversed.end && left != 0; ++column)
        if (inside || column < run.begin || column >= run.end) f(grid.number(column, row)), --left;
    }
  }
}

}  // namespace swiftgs
