// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"

// One thread: decides whether the frame fits, and writes the numbers of workgroups of later kernels.
layout(push_constant, scalar) uniform Push {
  TotalsAt to;
  Uints report, groups;  // of the splats, then of the intersections
  Count visible;
  uint splat_capacity, intersection_capacity, draws, splats_part, intersections_part;  // of sorts
};

// `VkDispatchIndirectCommand` for workgroups of `each` elements, as `Shape::of`.
void store_command(uint at, uint elements, uint each) {
  const uint all = (elements + each - 1u) / each, rows = max((all + 65534u) / 65535u, 1u);
  groups.at[at] = (all + rows - 1u) / rows;
  groups.at[at + 1u] = rows;
  groups.at[at + 2u] = 1u;
}
// `Groups` of the host.
void store_groups(uint at, uint elements, uint part) {
  store_command(at, elements, 128u);
  store_command(at + 3u, elements, 512u);
  store_command(at + 6u, elements, part);
}

void main() {
  if (thread() != 0u) return;
  const uint splats = number_of(visible);
  const uvec2 intersections = to.totals.intersections;
  const bool fits = draws != 0u && (splat_capacity == 0u || splats <= splat_capacity) &&
                    (intersection_capacity == 0u || (intersections.y == 0u && intersections.x <= intersection_capacity));
  const uint overflowed = fits ? 0u : 1u;
  to.totals.visible = uvec2(splats, 0u);
  to.totals.overflowed = uvec2(overflowed, 0u);
  to.totals.splats = fits ? splats : 0u;
  to.totals.kept_intersections = fits ? intersections.x : 0u;
  store_groups(0u, fits ? splats : 0u, splats_part);
  store_groups(9u, fits ? intersections.x : 0u, intersections_part);
  report.at[0] = splats;
  report.at[1] = 0u;
  report.at[2] = intersections.x;
  report.at[3] = intersections.y;
  report.at[4] = overflowed;
  report.at[5] = 0u;
}
