// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"
#include "places.glsl"

// Adds up the tiles of each workgroup's splats in the given order; in index order where it is null.
layout(push_constant, scalar) uniform Push {
  Footprints footprints;
  uvec2 order;
  Uints sums, runs;
  Count count;
};

void main() {
  const uint i = invocation();
  if (workgroup() * THREADS >= number_of(count)) return;
  uint total, tiles = 0u;
  if (i < number_of(count)) tiles = footprints.at[is_null(order) ? i : Uints(order).at[i]].z;
  sum_before(tiles, total);
  if (thread() == 0u) add_number(sums, runs, workgroup(), total);
}
