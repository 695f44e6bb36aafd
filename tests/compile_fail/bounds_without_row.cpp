// SPDX-License-Identifier: Apache-2.0
// expected: bounds\.row\(shape, rect, row\)
#include <swiftgs/swiftgs.hpp>

struct WholeImage {
  static constexpr std::string_view name = "whole-image";
  static constexpr bool lossless = true;
  swiftgs::TileRect rect(const swiftgs::SplatShape&, swiftgs::TileGrid grid) const {
    return {{0, grid.columns}, {0, grid.rows}};
  }
#ifdef SWIFTGS_EXPECT_COMPILE
  swiftgs::TileRun row(const swiftgs::SplatShape&, swiftgs::TileRect rect, int) const { return rect.columns; }
#endif
};

using Refused = swiftgs::Renderer<swiftgs::Serial, swiftgs::EarlySort, swiftgs::PerPixel, WholeImage>;
constexpr auto name = Refused::name;
