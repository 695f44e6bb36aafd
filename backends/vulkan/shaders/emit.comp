// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"

layout(constant_id = 3) const uint BOUNDS = ellipse;
layout(constant_id = 4) const uint KEY_WORDS = 1u;

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
  Uints key = Uints(element(uvec2(keys), at, 4u * KEY_WORDS));
  if (KEY_WORDS == 1u) {
    key.at[0] = tile;
  } else {
    key.at[0] = floatBitsToUint(depths.at[id]) | (tile << 31);
    key.at[1] = tile >> 1;
  }
}

// Splats of this workgroup without a mask, which all its threads emit together: some have more tiles than a driver lets
// one loop run (lavapipe ends loops after 65,535 rounds).
shared uint large[THREADS];
shared uint large_count;

uint id_of(uint i) { return is_null(order) ? i : Uints(order).at[i]; }

// A thread has a row of tiles at a time.
void emit_large(uint i) {
  const uint id = id_of(i), tiles_in_all = footprints.at[id].z;
  const TileGrid grid = grids.at[view_at(of_view, id)];
  const Shape shape = shape_of(shapes.at[id]);
  const SplatTiles tiles = tiles_of(BOUNDS, shape, grid);
  uint before_rows = 0u;
  for (int first = tiles.rows.begin; first < tiles.rows.end; first += int(THREADS)) {
    const int row = first + int(thread());
    TileRun run = tile_run(0, 0);
    if (row < tiles.rows.end) run = tiles_of_row(BOUNDS, tiles, shape, grid, row);
    uint of_rows;
    uint at = before_rows + sum_before(uint(run_size(run)), of_rows);
    for (int column = run.begin; column < run.end && at < tiles_in_all; ++column)
      store(offsets.at[i] + at++, tile_number(grid, column, row), id);
    before_rows += of_rows;
  }
}

void main() {
  if (thread() == 0u) large_count = 0u;
  barrier();
  const uint i = invocation();
  if (i < number_of(count)) {
    const uint id = id_of(i);
    const uvec4 footprint = footprints.at[id];
    const uint stride = grids.at[view_at(of_view, id)].stride;
    uint at = offsets.at[i];
    for (uint half_mask = 0u; half_mask < 2u; ++half_mask)
      for (uint mask = footprint[half_mask]; mask != 0u; mask &= mask - 1u) {
        const uint bit = uint(findLSB(mask));
        store(at++, footprint.w + (4u * half_mask + bit / 8u) * stride + bit % 8u, id);
      }
    if ((footprint.x | footprint.y) == 0u && footprint.z != 0u) large[atomicAdd(large_count, 1u)] = i;
  }
  barrier();
  for (uint k = 0u; k < large_count; ++k) emit_large(large[k]);
}
