// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <swiftgs/api.hpp>
#include <swiftgs/bounds/bounds.hpp>

namespace swiftgs {

/// Exactly the tiles that the ellipse s <= reach meets.
struct SWIFTGS_API Ellipse {
  static constexpr std::string_view name = "ellipse";
  static constexpr bool lossless = true;

  SWIFTGS_HD TileRect rect(const SplatShape& shape, TileGrid grid) const { return opacity_box(shape, grid); }

  /// The part of the ellipse in a row of tiles is convex, so it spans one run of columns. Its left and right
  /// ends are the ellipse's own where those lie in the row, and on the row's nearer border where they do not.
  SWIFTGS_HD TileRun row(const SplatShape& shape, TileRect rect, int row) const {
    const float height = half_height(shape), slack = bounds_slack(shape.half_width, height);
    const float top = float(row * tile_side) + 0.5f - shape.mean.y - slack;
    const float bottom = top + float(tile_side - 1) + 2 * slack;

    // x = (u - l1 y) / l0 with u^2 + (l2 y)^2 = reach; the rightmost point lies at y = -steepest, the
    // leftmost at +steepest.
    const float slope = shape.l1 / shape.l2;
    const float steepest = height * slope / std::sqrt(1 + slope * slope);
    const float right = shape.mean.x + edge(shape, clamp(-steepest, top, bottom, height), 1.0f) + slack;
    const float left = shape.mean.x + edge(shape, clamp(steepest, top, bottom, height), -1.0f) - slack;
    const TileRun run = tiles_meeting(left, right, rect.columns.end);
    return {run.begin > rect.columns.begin ? run.begin : rect.columns.begin, run.end};
  }

 private:
  SWIFTGS_HD static float clamp(float y, float top, float bottom, float height) {
    y = y < top ? top : y > bottom ? bottom : y;
    return y < -height ? -height : y > height ? height : y;
  }
  SWIFTGS_HD static float edge(const SplatShape& shape, float y, float sign) {
    const float v = shape.l2 * y, rest = shape.reach - v * v;
    return (sign * std::sqrt(rest > 0 ? rest : 0.0f) - shape.l1 * y) / shape.l0;
  }
};

static_assert(BoundsPolicy<Ellipse>);

}  // namespace swiftgs
