// SPDX-License-Identifier: Apache-2.0
// expected: bounds: expected .tiles\(const SplatShape&, TileGrid\) const. whose result has .TileRect rect.
#include <swiftgs/swiftgs.hpp>

struct WholeImage {
  static constexpr std::string_view name = "whole-image";
  static constexpr bool conservative = true;
  struct Tiles {
    swiftgs::TileRect rect;
#ifdef SWIFTGS_EXPECT_COMPILE
    swiftgs::TileRun row(int) const { return rect.columns; }
#endif
  };
  Tiles tiles(const swiftgs::SplatShape&, swiftgs::TileGrid grid) const {
    return {{grid.columns, grid.rows}};
  }
};

using Refused = swiftgs::Renderer<swiftgs::Serial, swiftgs::EarlySort, swiftgs::PerPixel, WholeImage>;
constexpr auto name = Refused::name;
