// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"
#include "places.glsl"

// Adds up the tiles of the splats of each workgroup of emit.comp in the given order; in index order where it is null. A
// subgroup has a sum.
layout(push_constant, scalar) uniform Push {
  Footprints footprints;
  uvec2 order;
  Uints sums, runs;
  Count count;
};

const uint GROUPS = 4u;  // of THREADS splats, of this workgroup

void main() {
  const uint n = number_of(count);
  for (uint k = gl_SubgroupID; k < GROUPS; k += THREADS / SUBGROUP) {
    const uint group = GROUPS * workgroup() + k;
    if (group * THREADS >= n) return;
    uint tiles = 0u;
    [[unroll]] for (uint first = 0u; first < THREADS; first += SUBGROUP) {
      const uint i = group * THREADS + first + gl_SubgroupInvocationID;
      if (i < n) tiles += footprints.at[is_null(order) ? i : Uints(order).at[i]].z;
    }
    tiles = subgroupAdd(tiles);
    if (gl_SubgroupInvocationID == 0u) add_number(sums, runs, group, tiles);
  }
}
