// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <concepts>
#include <string_view>

#include <swiftgs/splats.hpp>
#include <swiftgs/tiles.hpp>

namespace swiftgs {

/// Columns and rows of tiles.
struct TileRect {
  TileRun columns, rows;
};

/// Policy: which tiles a splat may touch. `rect` is the box of those tiles; `row` the run of columns in one
/// row of it, within its columns. A run, not a test a tile, because an ellipse meets a row of tiles in one
/// piece: one evaluation a row decides all. `lossless` promises that no tile is left out in which a pixel
/// keeps the splat.
template <class P>
concept BoundsPolicy = requires(const P bounds, const SplatShape& shape, TileGrid grid, TileRect rect,
                                int row) {
  { P::name } -> std::convertible_to<std::string_view>;
  { P::lossless } -> std::convertible_to<bool>;
  { bounds.rect(shape, grid) } -> std::same_as<TileRect>;
  { bounds.row(shape, rect, row) } -> std::same_as<TileRun>;
};

/// Limits `v` to [low, high] before it becomes an integer, so that no float is too large for one.
SWIFTGS_HD inline int clamped_floor(float v, int low, int high) {
  return v >= float(low) ? (v < float(high) ? int(v) : high) : low;
}

/// Tiles of [0, count) that hold a pixel centre in [low, high] @units{pixels}.
SWIFTGS_HD inline TileRun tiles_between(float low, float high, int count) {
  constexpr float inv_side = 1.0f / tile_side;
  // The first centre at or above `low` is ceil(low - 0.5) + 0.5, the last at or below `high` is floor(high -
  // 0.5) + 0.5.
  const float first = std::ceil(low - 0.5f), last = std::floor(high - 0.5f);
  if (!(first <= last && last >= 0)) return {};
  return {clamped_floor(first * inv_side, 0, count), clamped_floor(last * inv_side + 1, 0, count)};
}

/// Tiles of [0, count) whose span from first to last pixel centre meets [low, high] @units{pixels}. Columns
/// are found so: a rasterizer visits the rows of pixels in which the span meets the ellipse, and rounded
/// terms may keep a centre there although the ellipse passes between two.
SWIFTGS_HD inline TileRun tiles_meeting(float low, float high, int count) {
  constexpr float inv_side = 1.0f / tile_side;
  const float first = std::ceil((low - (float(tile_side) - 0.5f)) * inv_side);
  const float last = std::floor((high - 0.5f) * inv_side);
  return {clamped_floor(first, 0, count), clamped_floor(last + 1, 0, count)};
}

/// How much a lossless bound is widened, so that rounding in it never cuts what a rasterizer keeps.
/// @units{pixels}
SWIFTGS_HD inline float bounds_slack(float half_width, float half_height) {
  return 1e-2f + 1e-4f * (half_width + half_height);
}

/// Half the height of the ellipse s <= reach @units{pixels}.
SWIFTGS_HD inline float half_height(const SplatShape& shape) { return std::sqrt(shape.reach) / shape.l2; }

/// Tiles that the box of the ellipse s <= reach touches.
SWIFTGS_HD inline TileRect opacity_box(const SplatShape& shape, TileGrid grid) {
  const float height = half_height(shape), slack = bounds_slack(shape.half_width, height);
  const float x = shape.half_width + slack, y = height + slack;
  return {tiles_meeting(shape.mean.x - x, shape.mean.x + x, grid.columns),
          tiles_between(shape.mean.y - y, shape.mean.y + y, grid.rows)};
}

}  // namespace swiftgs
