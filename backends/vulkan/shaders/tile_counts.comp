// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"

// Numbers of tiles of the splats in the given order; of index order where it is null.
layout(push_constant, scalar) uniform Push {
  Footprints footprints;
  uvec2 order;
  Uints counts;
  Count count;
};

void main() {
  const uint i = invocation();
  if (i < number_of(count)) counts.at[i] = footprints.at[is_null(order) ? i : Uints(order).at[i]].z;
}
