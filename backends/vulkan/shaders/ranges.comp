// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"

layout(constant_id = 3) const uint KEY_WORDS = 1u;

// Marks where the intersections of each tile begin and end in keys sorted by tile. Collects tiles with long
// lists behind the length from which on they are, which rasterization starts with: `long_launch` has their number of 8x8
// blocks, `tile_blocks` each.
layout(push_constant, scalar) uniform Push {
  Uints keys, ranges, long_launch, long_tiles;
  Count count;
  uint tiles, tile_blocks;
};

uint tile_at(uint i) {
  if (KEY_WORDS == 1u) return keys.at[i];
  Uints key = pair_at(keys, i);
  return (key.at[0] >> 31) | (key.at[1] << 1);
}

void main() {
  const uint n = number_of(count), long_list = long_tiles.at[0];
  [[unroll]] for (uint k = 0u; k < 4u; ++k) {
    const uint i = (4u * workgroup() + k) * THREADS + thread();
    if (i >= n) continue;
    const uint tile = tile_at(i);
    if (tile >= tiles) continue;
    if (i == 0u || tile_at(i - 1u) != tile) {
      ranges.at[2u * tile] = i;
      if (n - i >= long_list && tile_at(i + long_list - 1u) == tile)
        long_tiles.at[1u + atomicAdd(long_launch.at[0], tile_blocks) / tile_blocks] = tile;
    }
    if (i + 1u == n || tile_at(i + 1u) != tile) ranges.at[2u * tile + 1u] = i + 1u;
  }
}
