// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/bounds.hpp>

namespace swiftgs {

/// INRIA's square of half side ceil(3 sigma) along the larger axis, whatever the opacity. It cuts alpha up to
/// opacity exp(-4.5), about 0.011, and lists faint splats where they show nothing.
struct SWIFTGS_API ThreeSigmaSquare {
  static constexpr std::string_view name = "three-sigma-square";
  static constexpr bool conservative = false;

  SWIFTGS_HD BoxTiles tiles(const SplatShape& shape, TileGrid grid) const {
    // Invert the factor: var_y = k / l2^2, var_x = k (1 / l0^2 + (l1 / (l0 l2))^2), det = (k / (l0 l2))^2.
    const float k = 0.72134752044448170368f;  // log2(e) / 2
    const float slope = shape.l1 / shape.l2;
    const float var_y = k / (shape.l2 * shape.l2);
    const float var_x = k * (1 + slope * slope) / (shape.l0 * shape.l0);
    const float mid = 0.5f * (var_x + var_y);
    const float root_det = k / (shape.l0 * shape.l2);
    const float gap = (mid - root_det) * (mid + root_det);
    const float radius = std::ceil(3 * std::sqrt(mid + std::sqrt(gap > 0.1f ? gap : 0.1f)));
    return {{span(shape.mean.x - 0.5f, radius, grid, grid.columns),
             span(shape.mean.y - 0.5f, radius, grid, grid.rows)}};
  }

 private:
  /// `centre` counts from the first pixel's centre, as INRIA's coordinates do.
  SWIFTGS_HD static TileRun span(float centre, float radius, TileGrid grid, TileRun among) {
    const float inverse_side = inverse_of(grid.side);
    return tile_run((centre - radius) * inverse_side, (centre + radius + float(grid.side - 1)) * inverse_side)
        .within(among);
  }
};

static_assert(BoundsPolicy<ThreeSigmaSquare>);

}  // namespace swiftgs
