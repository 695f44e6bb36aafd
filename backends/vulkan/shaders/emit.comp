// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"
#include "places.glsl"
#include "tiles.glsl"

layout(constant_id = 4) const uint KEY_WORDS = 1u;

// Writes a key and an id for each tile of a workgroup's splats in the given order, from its place on. Keys of two words
// hold the tile above the 31 bits of the depth, others the tile alone.
layout(push_constant, scalar) uniform Push {
  Shapes shapes;
  Floats depths;
  uvec2 of_view, order;
  Grids grids;
  Footprints footprints;
  Uints sums, runs;  // numbers of tiles
  Uints keys, ids;
  Count count;
};

void store(uint at, uint tile, uint id) {
  ids.at[at] = id;
  if (KEY_WORDS == 1u) {
    keys.at[at] = tile;
  } else {
    Uints key = pair_at(keys, at);
    key.at[0] = floatBitsToUint(depths.at[id]) | (tile << 31);
    key.at[1] = tile >> 1;
  }
}

// Splats of this workgroup without a mask. x: id, y: place of its first intersection, z: tiles, w: tiles of the large
// splats before it.
shared uvec4 large[THREADS];
shared int first_rows[THREADS];    // of tiles
shared uint rows_before[THREADS];  // rows of the large splats before it
shared uint large_count;

// Emits them by all threads, a row of tiles each: some have more rows than a workgroup has threads, many have few.
void emit_large() {
  const uint own = thread();
  uint tiles = 0u, rows = 0u, all_tiles, all_rows;
  if (own < large_count) {
    const uint id = large[own].x;
    const TileRun run = tiles_of(BOUNDS, shape_of(shapes.at[id]), grids.at[view_at(of_view, id)]).rows;
    tiles = large[own].z;
    rows = uint(run_size(run));
    first_rows[own] = run.begin;
  }
  const uint tiles_before = sum_before(tiles, all_tiles);
  rows_before[own] = sum_before(rows, all_rows);
  if (own < large_count) large[own].w = tiles_before;
  barrier();

  uint before = 0u;
  for (uint first = 0u; first < all_rows; first += THREADS) {
    const uint nth = first + own;
    // The last splat that begins at this row or before.
    uint of = 0u;
    for (uint step = THREADS / 2u; step > 0u; step /= 2u)
      if (of + step < large_count && rows_before[of + step] <= nth) of += step;
    const uvec4 splat = large[of];
    const TileGrid grid = grids.at[view_at(of_view, splat.x)];
    const int row = first_rows[of] + int(nth - rows_before[of]);
    TileRun run = tile_run(0, 0);
    if (nth < all_rows) {
      const Shape shape = shape_of(shapes.at[splat.x]);
      run = tiles_of_row(BOUNDS, tiles_of(BOUNDS, shape, grid), shape, grid, row);
    }
    uint found;
    uint at = before + sum_before(uint(run_size(run)), found) - splat.w;
    // Eight columns a round: lavapipe ends the loops of a thread after 65,535 rounds of all of them.
    for (int first_column = run.begin; first_column < run.end; first_column += 8)
      [[unroll]] for (int k = 0; k < 8; ++k)
        if (first_column + k < run.end && at < splat.z)
          store(splat.y + at++, tile_number(grid, first_column + k, row), splat.x);
    before += found;
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
  const uint place = numbers_before(sums, runs, workgroup()) + sum_before(footprint.z, total);
  if ((footprint.x | footprint.y) == 0u && footprint.z != 0u)
    large[atomicAdd(large_count, 1u)] = uvec4(id, place, footprint.z, 0u);
  emit_masks(id, footprint, stride, place);
  barrier();
  if (large_count != 0u) emit_large();
}
