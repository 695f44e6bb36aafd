// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <concepts>
#include <cstdint>
#include <string_view>
#include <utility>

#include <swiftgs/splats.hpp>
#include <swiftgs/tiles.hpp>

namespace swiftgs {

/// Columns and rows of tiles.
struct TileRect {
  TileRun columns, rows;
};

/// Tiles that a splat may touch where each row has all columns. Bounds whose rows differ have a type of
/// their own, which holds what is computed once a splat.
struct BoxTiles {
  TileRect rect;

  SWIFTGS_HD TileRun row(int) const { return rect.columns; }
};

/// Policy: which tiles a splat may touch. `tiles` finds the box of those tiles, `rect`, and prepares what its
/// rows need; `row` then finds the run of columns in one row of the box. An ellipse meets a row of tiles in
/// one run, so one evaluation per row replaces a test per tile. Conservative bounds include every tile in
/// which a pixel keeps the splat, and every tile that the test of a warp block accepts: the ellipse s
/// <= 1.0001 cutoff meets the box of its 8x8 pixel centres. Devices cut long lists into segments of such
/// splats. A splat between two rows of pixel centres is listed nowhere.
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

/// Limits `v` to [low, high] before it becomes an integer, so that no float is too large for one.
SWIFTGS_HD inline int clamped_floor(float v, int low, int high) {
  return v >= float(low) ? (v < float(high) ? int(v) : high) : low;
}

/// 1 / side of a tile: exact and without a division, since of a power of two only the exponent changes sign.
SWIFTGS_HD inline float inverse_of(int side) {
  return __builtin_bit_cast(float, 0x7f000000u - __builtin_bit_cast(std::uint32_t, float(side)));
}

/// Tiles of `among` that hold a pixel centre in [low, high] @units{pixels}.
SWIFTGS_HD inline TileRun tiles_between(float low, float high, int side, TileRun among) {
  const float inverse_side = inverse_of(side);
  // The first centre at or above `low` is ceil(low - 0.5) + 0.5, the last at or below `high` is floor(high -
  // 0.5) + 0.5.
  const float first = std::ceil(low - 0.5f), last = std::floor(high - 0.5f);
  if (!(first <= last && last >= 0)) return {};
  return {clamped_floor(first * inverse_side, among.begin, among.end),
          clamped_floor(last * inverse_side + 1, among.begin, among.end)};
}

/// Tiles of `among` whose span from first to last pixel centre meets [low, high] @units{pixels}. For columns:
/// a rasterizer visits the rows of pixels in which the span meets the ellipse, and rounding may keep a centre
/// there although the ellipse passes between two.
SWIFTGS_HD inline TileRun tiles_meeting(float low, float high, int side, TileRun among) {
  const float inverse_side = inverse_of(side);
  const float first = std::ceil((low - (float(side) - 0.5f)) * inverse_side);
  const float last = std::floor((high - 0.5f) * inverse_side);
  return {clamped_floor(first, among.begin, among.end), clamped_floor(last + 1, among.begin, among.end)};
}

/// How much a conservative bound is widened, so that rounding never cuts a pixel that a rasterizer keeps.
/// @units{pixels}
SWIFTGS_HD inline float bounds_slack(float half_width, float half_height) {
  return 1e-2f + 1e-4f * (half_width + half_height);
}

/// Half the height of the ellipse s <= cutoff @units{pixels}.
SWIFTGS_HD inline float half_height(const SplatShape& shape) {
  return std::sqrt(shape.cutoff) * (1 / shape.l2);
}

/// Half its width. No square leaves the range of float where the variance does not. @units{pixels}
SWIFTGS_HD inline float half_width(const SplatShape& shape) {
  const float inverse_l0 = 1 / shape.l0, tilt = shape.l1 * inverse_l0 * (1 / shape.l2);
  return std::sqrt(shape.cutoff) * std::sqrt(inverse_l0 * inverse_l0 + tilt * tilt);
}

/// Half the width and the height of the ellipse s <= cutoff, and `bounds_slack`. @units{pixels}
struct EllipseExtent {
  float width, height, slack;

  SWIFTGS_HD explicit EllipseExtent(const SplatShape& shape)
      : width(half_width(shape)), height(half_height(shape)), slack(bounds_slack(width, height)) {}
};

/// Tiles that the box of the ellipse s <= cutoff touches.
SWIFTGS_HD inline TileRect opacity_box(const SplatShape& shape, TileGrid grid) {
  const EllipseExtent half(shape);
  const float x = half.width + half.slack, y = half.height + half.slack;
  return {tiles_meeting(shape.mean.x - x, shape.mean.x + x, grid.side, grid.columns),
          tiles_between(shape.mean.y - y, shape.mean.y + y, grid.side, grid.rows)};
}

}  // namespace swiftgs
