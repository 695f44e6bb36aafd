// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"
#include "places.glsl"
#include "tiles.glsl"

// Gives the splats of a view and a placed scene their places, and finds their footprints. Counts the tiles of splats
// beyond the capacity too.
layout(push_constant, scalar) uniform Push {
  Shapes from;  // of this view and scene
  Projecteds projected;
  Uints counts, runs;    // visible Gaussians of all workgroups of projection
  Shapes shapes;
  Floats depths;
  Uints gaussians;
  uvec2 of_view;  // null if there is one view
  Footprints footprints;
  TotalsAt to;
  Grids grid;
  uint candidates, capacity, first_gaussian, first_workgroup, view;
};

void main() {
  if (workgroup() * THREADS >= candidates) return;
  const uint of_all = first_workgroup + workgroup(), visible = counts.at[of_all];
  if (visible == 0u) return;
  const uint first = numbers_before(counts, runs, of_all);
  uint tiles = 0u;
  if (thread() < visible) {
    const ShapeWords shape = from.at[workgroup() * THREADS + thread()];
    const uvec2 depth_gaussian = projected.at[workgroup() * THREADS + thread()];
    const uvec4 footprint = footprint_of(BOUNDS, shape_of(shape), grid.at[0]);
    const uint at = first + thread();
    tiles = footprint.z;
    if (at < capacity) {
      shapes.at[at] = shape;
      depths.at[at] = uintBitsToFloat(depth_gaussian.x);
      gaussians.at[at] = first_gaussian + depth_gaussian.y;
      footprints.at[at] = footprint;
      // Two views share a word, which was cleared.
      if (!is_null(of_view)) atomicOr(Uints(of_view).at[at >> 1], view << (16u * (at & 1u)));
    }
  }
  add_tiles(to, tiles);
}
