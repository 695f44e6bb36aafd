// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include <swiftgs/bounds/bounds.hpp>
#include <swiftgs/span.hpp>
#include <swiftgs/tiles.hpp>

namespace swiftgs {

/// The tiles that a splat may touch, found once; emission expands them to instances.
struct alignas(16) Footprint {
  /// Side of the mask in tiles.
  static constexpr int side = 8;

  std::uint64_t mask = 0;   ///< bit 8 r + c: the tile r rows below and c columns right of the first; zero
                            ///< where the splat spans more than 8 tiles a side, or touches none
  std::uint32_t count = 0;  ///< of tiles
  std::uint16_t column = 0, row = 0;  ///< of the first tile
};
static_assert(sizeof(Footprint) == 16);

/// The tiles of each splat of a frame within `Bounds`, on one grid. Holds for these bounds and this grid
/// alone.
template <BoundsPolicy Bounds>
struct FootprintsView {
  Span<const Footprint> each{};  ///< @shape{splats} or empty: whoever needs them finds them
  std::uint64_t instances = 0;   ///< sum of their counts
  TileGrid grid;                 ///< of no tiles where nothing was projected
};

/// Storage of one frame's footprints on backend `B`. Here for backends that find none while they project.
template <class B, BoundsPolicy Bounds>
struct Footprints {
  TileGrid grid;

  FootprintsView<Bounds> view() const { return {.grid = grid}; }
  std::size_t bytes() const { return 0; }
};

}  // namespace swiftgs
