// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include <swiftgs/math.hpp>
#include <swiftgs/span.hpp>

namespace swiftgs {

/// Side of the squares of pixels that rasterizers blend at a time @units{pixels}. Tiles are as large or
/// larger: the squares of a tile share its list.
inline constexpr int square_side = 16;

/// Side of the tiles that a renderer lists splats for @units{pixels}.
inline constexpr int default_tile_side = square_side;

/// Tiles that cover an image, numbered by rows. The side changes how long lists are. It changes no bit of an
/// image within lossless bounds; others cut splats at the borders of tiles.
struct TileGrid {
  int columns = 0, rows = 0;
  int side = default_tile_side;  ///< a power of two, `square_side` or more @units{pixels}

  SWIFTGS_HD static constexpr TileGrid covering(int width, int height, int side = default_tile_side) {
    return {(width + side - 1) / side, (height + side - 1) / side, side};
  }
  SWIFTGS_HD constexpr std::size_t size() const { return std::size_t(columns) * std::size_t(rows); }
  bool operator==(const TileGrid&) const = default;

  /// Number of the tile that holds pixel (x, y).
  SWIFTGS_HD std::uint32_t tile_at(int x, int y) const {
#if defined(__CUDA_ARCH__)
    const int shift = 31 - __clz(side);  // a division costs twenty instructions
    return std::uint32_t((y >> shift) * columns + (x >> shift));
#else
    return std::uint32_t(y / side * columns + x / side);
#endif
  }

  /// Bits that tell all tiles apart. A sort by tile looks at these.
  SWIFTGS_HD constexpr int key_bits() const {
    int bits = 0;
    while ((std::size_t(1) << bits) < size()) ++bits;
    return bits;
  }
};

/// Half-open range of tile columns or rows.
struct TileRun {
  int begin = 0, end = 0;

  SWIFTGS_HD constexpr int size() const { return end > begin ? end - begin : 0; }
};

/// Half-open range of positions in `TileListsView::ids`.
struct TileRange {
  std::uint32_t begin = 0, end = 0;
};

/// For each tile the splats that may touch it, front to back.
struct TileListsView {
  Span<const std::uint32_t> ids;  ///< @shape{instances} indices of splats
  Span<const TileRange> ranges;   ///< @shape{tiles}
};

/// Storage of one frame's tile lists on backend `B`.
template <class B>
struct TileLists {
  typename B::template Buffer<std::uint32_t> ids;
  typename B::template Buffer<TileRange> ranges;
  std::size_t instances = 0;
  std::size_t tiles = 0;

  std::size_t bytes() const { return ids.bytes() + ranges.bytes(); }

  TileListsView view() const { return {{ids.data(), instances}, {ranges.data(), tiles}}; }
};

/// Most instances that one frame may have.
inline constexpr std::uint64_t max_instances = std::uint64_t(1) << 31;

}  // namespace swiftgs
