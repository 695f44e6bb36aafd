// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/bounds.hpp>

namespace swiftgs {

/// The box of the ellipse outside which alpha is below the threshold: faint splats get small boxes.
struct SWIFTGS_API OpacityBox {
  static constexpr std::string_view name = "opacity-box";
  static constexpr bool conservative = true;

  SWIFTGS_HD BoxTiles tiles(const SplatShape& shape, TileGrid grid) const {
    return {opacity_box(shape, EllipseExtent(shape), grid.side).within(grid)};
  }
};

static_assert(BoundsPolicy<OpacityBox>);

}  // namespace swiftgs
