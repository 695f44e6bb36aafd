// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include <swiftgs/cpu.hpp>

namespace swiftgs {

/// Count of a splat too large for a mask, whose tiles have yet to be counted.
inline constexpr std::uint32_t to_be_counted = 0xffffffffu;

/// Footprints of `count` consecutive splats within the bounds: the same tiles as the bounds' own `rect` and
/// `row`, found for a register of splats at a time.
void find_footprints(const ThreeSigmaSquare&, const SplatShape* shapes, std::size_t count, TileGrid grid,
                     Footprint* out);
void find_footprints(const OpacityBox&, const SplatShape* shapes, std::size_t count, TileGrid grid,
                     Footprint* out);
void find_footprints(const Ellipse&, const SplatShape* shapes, std::size_t count, TileGrid grid,
                     Footprint* out);

}  // namespace swiftgs
