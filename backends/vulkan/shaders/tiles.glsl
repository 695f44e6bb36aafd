// SPDX-License-Identifier: Apache-2.0

layout(constant_id = 3) const uint BOUNDS = ellipse;

// Adds the tiles of a workgroup's splats to the frame's. A splat has 2^24 at most, so their sum keeps to 32 bits.
void add_tiles(TotalsAt to, uint tiles) {
  uint all;
  sum_before(tiles, all);
  if (thread() == 0u && all != 0u) add_halves(Uints(element(uvec2(to), 1u, 8u)), all, 0u);
}
