// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"
#include "tiles.glsl"

// Finds the footprints of splats that have their places.
layout(push_constant, scalar) uniform Push {
  Shapes shapes;
  uvec2 of_view;
  Grids grids;  // of the views
  Footprints footprints;
  TotalsAt to;
  Count count;
};

void main() {
  if (workgroup() * THREADS >= count.most) return;
  const uint i = invocation();
  uvec4 footprint = uvec4(0u);
  if (i < number_of(count)) {
    footprint = footprint_of(BOUNDS, shape_of(shapes.at[i]), grids.at[view_at(of_view, i)]);
    footprints.at[i] = footprint;
  }
  add_tiles(to, footprint.z);
}
