// SPDX-License-Identifier: Apache-2.0

layout(constant_id = 3) const uint BOUNDS = ellipse;

// Adds up the tiles of a workgroup's splats, in halves that do not leave 32 bits.
void add_tiles(Uints tile_counts, uint tiles) {
  uint low, high;
  sum_before(tiles & 0xffffu, low);
  sum_before(tiles >> 16, high);
  if (thread() == 0u) {
    tile_counts.at[2u * workgroup()] = low;
    tile_counts.at[2u * workgroup() + 1u] = high;
  }
}
