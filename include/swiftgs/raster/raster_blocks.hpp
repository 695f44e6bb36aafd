// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include <swiftgs/math.hpp>
#include <swiftgs/tiles.hpp>
#include <swiftgs/views.hpp>

namespace swiftgs {

/// A raster block of a view.
struct RasterBlockPlace {
  std::uint32_t view;  ///< index
  int x, y;            ///< its first pixel in the view's frame
};

/// The raster blocks of all views. They are numbered as tiles are, but are smaller where tiles are larger.
struct RasterBlocks {
  std::uint32_t columns, rows;
  std::uint32_t of_tile;  ///< a side

  SWIFTGS_HD explicit RasterBlocks(const FrameTiles& tiles)
      : columns(tiles.columns * std::uint32_t(tiles.side / raster_block_side)),
        rows(tiles.rows * std::uint32_t(tiles.side / raster_block_side)),
        of_tile(std::uint32_t(tiles.side / raster_block_side)) {}
  SWIFTGS_HD std::size_t size() const { return std::size_t(columns) * rows; }

  /// Where the raster block in this column and row lies. It may lie outside of the view's frame.
  SWIFTGS_HD RasterBlockPlace place(const View* views, std::uint32_t count, std::uint32_t column,
                                    std::uint32_t row) const {
    const std::uint32_t tiles = columns / of_tile;
    const std::uint32_t view = count == 1 ? 0 : view_of_tile(views, count, row / of_tile * tiles);
    const std::uint32_t first_row = count == 1 ? 0 : views[view].grid.first / tiles * of_tile;
    return {view, int(column) * raster_block_side, int(row - first_row) * raster_block_side};
  }
};

}  // namespace swiftgs
