// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"

// One workgroup: adds up all tiles, and decides whether the frame fits.
layout(push_constant, scalar) uniform Push {
  Uints tile_counts;
  TotalsAt to;
  Uints report;
  Count visible;
  uint groups, splat_capacity, intersection_capacity, draws;
};

shared uvec2 sums[THREADS];

uvec2 plus(uvec2 a, uint high, uint low) {
  uint carry;
  const uint sum = uaddCarry(a.x, low, carry);
  return uvec2(sum, a.y + high + carry);
}

void main() {
  uvec2 sum = uvec2(0u);
  for (uint g = thread(); g < groups; g += THREADS) {
    const uint high = tile_counts.at[2u * g + 1u];
    sum = plus(plus(sum, 0u, tile_counts.at[2u * g]), high >> 16, high << 16);
  }
  sums[thread()] = sum;
  barrier();
  if (thread() != 0u) return;
  uvec2 intersections = uvec2(0u);
  for (uint t = 0u; t < THREADS; ++t) intersections = plus(intersections, sums[t].y, sums[t].x);
  const uint splats = number_of(visible);
  const bool fits = draws != 0u && (splat_capacity == 0u || splats <= splat_capacity) &&
                    (intersection_capacity == 0u || (intersections.y == 0u && intersections.x <= intersection_capacity));
  const uint overflowed = fits ? 0u : 1u;
  to.totals.visible = uvec2(splats, 0u);
  to.totals.intersections = intersections;
  to.totals.overflowed = uvec2(overflowed, 0u);
  to.totals.splats = fits ? splats : 0u;
  to.totals.kept_intersections = fits ? intersections.x : 0u;
  report.at[0] = splats;
  report.at[1] = 0u;
  report.at[2] = intersections.x;
  report.at[3] = intersections.y;
  report.at[4] = overflowed;
  report.at[5] = 0u;
}
