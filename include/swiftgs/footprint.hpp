// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

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

}  // namespace swiftgs
