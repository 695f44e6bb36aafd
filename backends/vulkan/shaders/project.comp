// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"
#include "places.glsl"

// Projects the Gaussians of a placed scene, through any lens with THROUGH_LENS: pinholes have a kernel of their own, which
// compiles in a fifth of the time. The visible ones of a workgroup lie side by side.

#ifdef THROUGH_LENS
layout(constant_id = 3) const uint LENS = perspective;
#else
const uint LENS = pinhole;
#endif

layout(set = 1, binding = 0, scalar) uniform Constants { Seen seen; };
layout(push_constant, scalar) uniform Push {
  Shapes shapes;  // of this scene
  Projecteds projected;
  Uints counts, runs;    // visible ones of all workgroups
  TotalsAt to;
  uint gaussians, first_workgroup;
};

// As `Clip::shows`.
bool shows(vec3 mean) {
  for (uint k = 0u; k < seen.half_space_count; ++k) {
    const vec4 h = seen.half_spaces[k];
    FloatPair sum = add(two_product(h.x, mean.x), add(two_product(h.y, mean.y), add(two_product(h.z, mean.z), pair(h.w, 0.0))));
    if (!(sum.high >= 0.0)) return false;
  }
  const float radius = seen.clip_radius;
  if (!(radius <= 3.4e38)) return true;
  const vec3 from = mean - seen.clip_centre;
  return dot(from, from) <= radius * radius;
}

void main() {
  if (workgroup() * THREADS >= gaussians) return;
  // A workgroup has a chunk.
  const uvec2 chunks = seen.scene.chunks;
  if (!is_null(chunks) && culls(LENS, seen.eye, seen.culler, Chunks(chunks).at[workgroup()])) {
    if (thread() == 0u) counts.at[first_workgroup + workgroup()] = 0u;
    return;
  }
  const uint i = invocation();
  ProjectedShape shape;
  shape.visible = false;
  if (i < gaussians) {
    const Gaussian g = gaussian_of(seen.scene, i);
#ifdef THROUGH_LENS
    if (shows(g.mean)) shape = project_through_lens(LENS, seen.eye, g);
#else
    if (shows(g.mean)) shape = project_through_pinhole(seen.eye, g);
#endif
  }
  uint visible;
  const uint place = workgroup() * THREADS + sum_before(shape.visible ? 1u : 0u, visible);
  if (shape.visible) {
    shapes.at[place] = stored_shape(shape.shape);
    projected.at[place] = uvec2(floatBitsToUint(shape.depth), i);
  }
  if (thread() == 0u) {
    add_number(counts, runs, first_workgroup + workgroup(), visible);
    if (visible != 0u) atomicAdd(to.totals.visible.x, visible);
  }
}
