// SPDX-License-Identifier: Apache-2.0
// clang-format off
// expected bounds_without_name: bounds: expected .static constexpr std::string_view name
// expected bounds_not_said_to_be_conservative: bounds: expected .static constexpr bool conservative
// expected bounds_without_row: bounds: expected .tiles\(const SplatShape&, TileGrid\) const. whose result has .TileRect rect.
// clang-format on
#include <swiftgs/swiftgs.hpp>

struct WholeImage {
#ifndef bounds_without_name
  static constexpr std::string_view name = "whole-image";
#endif
#ifndef bounds_not_said_to_be_conservative
  static constexpr bool conservative = true;
#endif
  struct Tiles {
    swiftgs::TileRect rect;
#ifndef bounds_without_row
    swiftgs::TileRun row(int) const { return rect.columns; }
#endif
  };
  Tiles tiles(const swiftgs::SplatShape&, swiftgs::TileGrid grid) const {
    return {{grid.columns, grid.rows}};
  }
};

using Refused = swiftgs::Renderer<swiftgs::Serial, swiftgs::EarlySort, swiftgs::PerPixel, WholeImage>;
constexpr auto name = Refused::name;
