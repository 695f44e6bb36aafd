// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"

layout(constant_id = 3) const uint BOUNDS = ellipse;
layout(constant_id = 4) const uint KEY_WORDS = 1u;

// Writes a key and an id for each tile of a workgroup's splats in the given order, from its place on. Keys of two words
// hold the tile above the 31 bits of the depth, others the tile alone.
layout(push_constant, scalar) uniform Push {
  Shapes shapes;
  Floats depths;
  uvec2 of_view, order;
  Grids grids;
  Footprints footprints;
  Uints places;  // of workgroups
  Uints keys, ids;
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
shared uvec2 large[THREADS];  // ids, and places
shared uint large_count;

// A thread has a row of tiles at a time.
void emit_large(uint id, uint place) {
  const uint tiles_in_all = footprints.at[id].z;
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
      store(place + at++, tile_number(grid, column, row), id);
    before_rows += of_rows;
  }
}

// Position of the n-th lowest bit that is set.
uint find_bit(uvec2 mask, uint n) {
  uint word = mask.x, position = 0u, low = bitCount(mask.x);
  if (n >= low) {
    n -= low;
    word = mask.y;
    position = 32u;
  }
  [[unroll]] for (uint half_size = 16u; half_size > 0u; half_size /= 2u) {
    low = bitCount(word & ((1u << half_size) - 1u));
    if (n >= low) {
      n -= low;
      word >>= half_size;
      position += half_size;
    }
  }
  return position;
}

// Emits the splats of a subgroup that have masks, an intersection a lane: neighbouring lanes write neighbouring words.
void emit_masks(uint id, uvec4 footprint, uint stride, uint place) {
  const uint tiles = (footprint.x | footprint.y) != 0u ? footprint.z : 0u;
  const uint end = subgroupInclusiveAdd(tiles), first = end - tiles, all = subgroupShuffle(end, SUBGROUP - 1u);
  for (uint from = 0u; from < all; from += SUBGROUP) {
    const uint position = from + gl_SubgroupInvocationID;
    // The last lane that begins at this position or before.
    uint owner = 0u;
    for (uint step = SUBGROUP / 2u; step > 0u; step /= 2u)
      if (subgroupShuffle(first, owner + step) <= position) owner += step;
    const uvec2 mask = uvec2(subgroupShuffle(footprint.x, owner), subgroupShuffle(footprint.y, owner));
    const uint first_tile = subgroupShuffle(footprint.w, owner), row_stride = subgroupShuffle(stride, owner);
    const uint of_splat = subgroupShuffle(id, owner), begin = subgroupShuffle(place, owner);
    const uint nth = position - subgroupShuffle(first, owner);
    if (position >= all) continue;
    const uint bit = find_bit(mask, nth);
    store(begin + nth, first_tile + bit / 8u * row_stride + bit % 8u, of_splat);
  }
}

void main() {
  if (workgroup() * THREADS >= number_of(count)) return;
  if (thread() == 0u) large_count = 0u;
  const uint i = invocation();
  uint id = 0u, stride = 0u, total;
  uvec4 footprint = uvec4(0u);
  if (i < number_of(count)) {
    id = is_null(order) ? i : Uints(order).at[i];
    footprint = footprints.at[id];
    stride = grids.at[view_at(of_view, id)].stride;
  }
  const uint place = places.at[workgroup()] + sum_before(footprint.z, total);
  if ((footprint.x | footprint.y) == 0u && footprint.z != 0u) large[atomicAdd(large_count, 1u)] = uvec2(id, place);
  emit_masks(id, footprint, stride, place);
  barrier();
  for (uint k = 0u; k < large_count; ++k) emit_large(large[k].x, large[k].y);
}
