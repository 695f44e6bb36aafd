// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <tuple>

#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/span.hpp>

namespace swiftgs {

/// Side of a raster block, the pixels that rasterizers blend at a time @units{pixels}. Tiles are as large or
/// larger: the raster blocks of a tile share its list.
inline constexpr int raster_block_side = 16;

/// Side of the tiles that a renderer lists splats for, unless coarser ones are quicker @units{pixels}.
inline constexpr int default_tile_side = raster_block_side;

/// Half-open range of tile columns or rows.
struct TileRun {
  int begin = 0, end = 0;

  SWIFTGS_HD constexpr int size() const { return end > begin ? end - begin : 0; }
  /// Whether its size is 1. Safe also where `end - begin` would overflow.
  SWIFTGS_HD constexpr bool is_one() const { return std::uint32_t(end) - std::uint32_t(begin) == 1; }
  /// The intersection of both runs, empty if they do not meet.
  SWIFTGS_HD constexpr TileRun within(TileRun among) const {
    return {limited(begin, among), limited(end, among)};
  }
  bool operator==(const TileRun&) const = default;

 private:
  SWIFTGS_HD static constexpr int limited(int tile, TileRun among) {
    const int below = tile < among.end ? tile : among.end;
    return below > among.begin ? below : among.begin;
  }
};

/// Tiles of an image by column and row from its top left corner, and their numbers in a frame. The side
/// changes the length of lists, and no image with conservative bounds; others cut splats at tile borders.
struct TileGrid {
  TileRun columns, rows;         ///< not negative
  int side = default_tile_side;  ///< a power of two, `raster_block_side` or more @units{pixels}
  std::uint32_t first = 0;       ///< number of the first tile of the first row
  std::uint32_t stride = 0;      ///< from a tile's number to that of the tile below

  /// A whole image, numbered by rows.
  SWIFTGS_HD static constexpr TileGrid covering(int width, int height, int side = default_tile_side) {
    const int columns = (width + side - 1) / side;
    return {{0, columns}, {0, (height + side - 1) / side}, side, 0, std::uint32_t(columns)};
  }
  SWIFTGS_HD constexpr std::size_t size() const {
    return std::size_t(columns.size()) * std::size_t(rows.size());
  }
  bool operator==(const TileGrid&) const = default;

  /// Number of a tile of the grid.
  SWIFTGS_HD constexpr std::uint32_t number(int column, int row) const {
    return first + std::uint32_t(row - rows.begin) * stride + std::uint32_t(column - columns.begin);
  }

  /// Number of the tile that holds pixel (x, y) of the image.
  SWIFTGS_HD std::uint32_t tile_at(int x, int y) const {
#if defined(__CUDA_ARCH__)
    const int shift = 31 - __clz(side);  // a division costs twenty instructions
    return number(x >> shift, y >> shift);
#else
    return number(x / side, y / side);
#endif
  }
};

/// The tiles of all views of a frame in one numbering: the grids lie one below the other, in rows as wide as
/// the widest. Where a grid is narrower, numbers are left over whose lists stay empty.
struct FrameTiles {
  std::uint32_t columns = 0, rows = 0;
  int side = default_tile_side;  ///< of all grids @units{pixels}

  SWIFTGS_HD constexpr std::size_t size() const { return std::size_t(columns) * rows; }
  bool operator==(const FrameTiles&) const = default;

  /// Bits that tell all tiles apart. A sort by tile looks at these.
  SWIFTGS_HD constexpr int key_bits() const {
    int bits = 0;
    while ((std::size_t(1) << bits) < size()) ++bits;
    return bits;
  }
};

/// The capacity of recorded frames: their parts `reserve` memory for it.
struct Reservation {
  std::size_t gaussians = 0, chunks = 0;  ///< of all placed scenes
  std::size_t views = 0;
  FrameTiles tiles;   ///< of all views
  Capacity capacity;  ///< neither is 0
};

/// Has all `parts` take the memory of `reserved` frames. A part without a member `reserve` takes it when it
/// is used.
template <class B, class... Parts>
void reserve_parts(B& b, const Reservation& reserved, Parts&... parts) {
  const auto reserve = [&](auto& part) {
    if constexpr (requires { part.reserve(b, reserved); }) part.reserve(b, reserved);
  };
  (reserve(parts), ...);
}

/// Most tiles that one frame may have.
inline constexpr std::size_t max_frame_tiles = std::size_t(1) << 31;

/// Half-open range of positions in `TileListsView::ids`.
struct TileRange {
  std::uint32_t begin = 0, end = 0;

  /// Marks tiles of an overflowed device frame: draw nothing.
  SWIFTGS_HD static constexpr TileRange undrawn() { return {1, 0}; }
  SWIFTGS_HD constexpr bool drawn() const { return begin <= end; }
};

/// For each tile the splats that may touch it, front to back.
struct TileListsView {
  Span<const std::uint32_t> ids;  ///< @shape{intersections} indices of splats
  Span<const TileRange> ranges;   ///< @shape{tiles}
};

/// Storage of one frame's tile lists on backend `B`.
template <class B>
struct TileLists {
  typename B::template Buffer<std::uint32_t> ids;
  typename B::template Buffer<TileRange> ranges;
  std::size_t intersections = 0;  ///< at most
  std::size_t tiles = 0;

  void reserve(B&, const Reservation& reserved) {
    ids.reset_exactly(reserved.capacity.intersections), ranges.reset_exactly(reserved.tiles.size());
  }
  static auto buffers(auto& self) { return std::tie(self.ids, self.ranges); }

  TileListsView view() const { return {{ids.data(), intersections}, {ranges.data(), tiles}}; }
};

/// Most intersections that one frame may have.
inline constexpr std::uint64_t max_intersections = std::uint64_t(1) << 31;

}  // namespace swiftgs
