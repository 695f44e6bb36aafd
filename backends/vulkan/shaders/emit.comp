// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"

layout(constant_id = 2) const uint BOUNDS = ellipse;
layout(constant_id = 3) const uint KEY_WORDS = 1u;

// Writes a key and an id for each tile of splat `order[i]`, from `offsets[i]` on. Keys of two words hold the tile above
// the 31 bits of the depth, others the tile alone.
layout(push_constant, scalar) uniform Push {
  Shapes shapes;
  Floats depths;
  uvec2 of_view, order;
  Grids grids;
  Footprints footprints;
  Uints offsets, keys, ids;
  Count count;
};

void store(uint at, uint tile, uint id) {
  ids.at[at] = id;
  if (KEY_WORDS == 1u) {
    keys.at[at] = tile;
  } else {
    keys.at[2u * at] = floatBitsToUint(depths.at[id]) | (tile << 31);
    keys.at[2u * at + 1u] = tile >> 1;
  }
}

void main() {
  const uint i = invocation();
  if (i >= number_of(count)) return;
  const uint id = is_null(order) ? i : Uints(order).at[i];
  const uvec4 footprint = footprints.at[id];
  const TileGrid grid = grids.at[view_at(of_view, id)];
  uint at = offsets.at[i];
  for (uint half_mask = 0u; half_mask < 2u; ++half_mask)
    for (uint mask = footprint[half_mask]; mask != 0u; mask &= mask - 1u) {
      const uint bit = uint(findLSB(mask));
      store(at++, footprint.w + (4u * half_mask + bit / 8u) * grid.stride + bit % 8u, id);
    }
  if ((footprint.x | footprint.y) != 0u || footprint.z == 0u) return;

  // A splat without a mask: as `for_each_tile`, whatever bounds say now it has as many tiles as were counted.
  const Shape shape = shapes.at[id];
  const SplatTiles tiles = tiles_of(BOUNDS, shape, grid);
  uint left = footprint.z;
  for (uint pass = 0u; pass < 2u; ++pass) {
    const int first_row = pass == 0u ? tiles.rows.begin : grid.first_row;
    const int end_row = pass == 0u ? tiles.rows.end : grid.end_row;
    for (int row = first_row; row < end_row && left != 0u; ++row) {
      TileRun run = tile_run(0, 0);
      if (row >= tiles.rows.begin && row < tiles.rows.end) run = tiles_of_row(BOUNDS, tiles, shape, grid, row);
      const int first = pass == 0u ? run.begin : grid.first_column, end = pass == 0u ? run.end : grid.end_column;
      for (int column = first; column < end && left != 0u; ++column)
        if (pass == 0u || column < run.begin || column >= run.end) {
          store(at++, tile_number(grid, column, row), id);
          --left;
        }
    }
  }
}
