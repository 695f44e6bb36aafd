// SPDX-License-Identifier: Apache-2.0

layout(constant_id = 3) const uint BOUNDS = ellipse;

// Adds the tiles of a workgroup's splats to the frame's, in halves that do not leave 32 bits.
void add_tiles(TotalsAt to, uint tiles) {
  uint low, high;
  sum_before(tiles & 0xffffu, low);
  sum_before(tiles >> 16, high);
  if (thread() == 0u && (low | high) != 0u) add_halves(Uints(element(uvec2(to), 1u, 8u)), low, high);
}
