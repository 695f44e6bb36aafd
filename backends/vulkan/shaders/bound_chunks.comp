// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"

// Bounds chunks anew, a workgroup each, as `bounds_of_chunk` does. A NaN widens nothing.
layout(push_constant, scalar) uniform Push {
  uvec2 means, scales, rotations;
  Floats opacities;
  Chunks chunks;
  uint first, end, gaussians;
};

#define INFINITE uintBitsToFloat(0x7f800000u)

shared float largest[THREADS / 4u];

float or_least(float x) { return (floatBitsToUint(x) & 0x7fffffffu) > 0x7f800000u ? -INFINITE : x; }

// The largest number of all threads, which all call it.
float largest_of_all(float x) {
  const float of_subgroup = subgroupMax(or_least(x));
  if (gl_SubgroupInvocationID == 0u) largest[gl_SubgroupID] = of_subgroup;
  barrier();
  float of_all = -INFINITE;
  for (uint s = 0u; s < THREADS / SUBGROUP; ++s) of_all = max(of_all, largest[s]);
  barrier();
  return of_all;
}

void main() {
  const uint chunk = first + workgroup();
  if (chunk >= end) return;
  const uint i = chunk * THREADS + thread();
  float below[3] = float[3](-INFINITE, -INFINITE, -INFINITE), above[3] = below;
  float size = 0.0, opacity = 0.0;
  if (i < gaussians) {
    const vec3 mean = vector_at(means, i, 12u), scales_of = abs(vector_at(scales, i, 12u));
    for (uint k = 0u; k < 3u; ++k) {
      above[k] = mean[k];
      below[k] = -mean[k];
      size = scales_of[k] > size ? scales_of[k] : size;
    }
    Floats q = Floats(element(rotations, i, 16u));
    float squares = 0.0;
    for (uint k = 0u; k < 4u; ++k) squares += q.at[k] * q.at[k];
    // How much longer the matrix of the quaternion makes a vector at most, and 4 units in the last place.
    size *= (squares + abs(1.0 - squares)) * 1.0000005;
    opacity = opacities.at[i];
  }
  Chunk bounds;
  for (uint k = 0u; k < 3u; ++k) {
    bounds.low[k] = -largest_of_all(below[k]);
    bounds.high[k] = largest_of_all(above[k]);
  }
  bounds.size = max(largest_of_all(size), 0.0);
  bounds.opacity = max(largest_of_all(opacity), 0.0);
  if (thread() == 0u) chunks.at[chunk] = bounds;
}
