// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"
#include "tile_counts.glsl"

// Gives the splats of a view and a placed scene their places, and finds their footprints. Counts the tiles of splats
// beyond the capacity too.
layout(push_constant, scalar) uniform Push {
  Projecteds projected;  // of this view and scene, as are places and tile counts
  Uints places;
  Shapes shapes;
  Floats depths;
  Uints gaussians;
  uvec2 of_view;  // null if there is one view
  Footprints footprints;
  Uints tile_counts;
  Grids grid;
  uint candidates, capacity, first_gaussian, view;
};

void main() {
  if (workgroup() * THREADS >= candidates) return;
  const uint first = places.at[workgroup()], visible = places.at[workgroup() + 1u] - first;
  uint tiles = 0u;
  if (thread() < visible) {
    const Projected p = projected.at[workgroup() * THREADS + thread()];
    const uvec4 footprint = footprint_of(BOUNDS, shape_of(p.shape), grid.at[0]);
    const uint to = first + thread();
    tiles = footprint.z;
    if (to < capacity) {
      shapes.at[to] = p.shape;
      depths.at[to] = uintBitsToFloat(p.depth_gaussian.x);
      gaussians.at[to] = first_gaussian + p.depth_gaussian.y;
      footprints.at[to] = footprint;
      // Two views share a word, which was cleared.
      if (!is_null(of_view)) atomicOr(Uints(of_view).at[to >> 1], view << (16u * (to & 1u)));
    }
  }
  add_tiles(tile_counts, tiles);
}
