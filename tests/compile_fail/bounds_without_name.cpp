// SPDX-License-Identifier: Apache-2.0
// expected: bounds: expected .static constexpr std::string_view name
#include <swiftgs/swiftgs.hpp>

struct WholeImage {
#ifdef SWIFTGS_EXPECT_COMPILE
  static constexpr std::string_view name = "whole-image";
#endif
  static constexpr bool conservative = true;
  swiftgs::BoxTiles tiles(const swiftgs::SplatShape&, swiftgs::TileGrid grid) const {
    return {{grid.columns, grid.rows}};
  }
};

using Refused = swiftgs::Renderer<swiftgs::Serial, swiftgs::EarlySort, swiftgs::PerPixel, WholeImage>;
constexpr auto name = Refused::name;
