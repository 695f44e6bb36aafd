// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"

// Projects the Gaussians of a placed scene. The visible ones of a workgroup lie side by side, and their number in
// `counts`.
layout(push_constant, scalar) uniform Push {
  Seens seen;
  Projecteds projected;  // of this scene
  Uints counts;
  uint gaussians;
};

vec3 vector_at(uvec2 data, uint i, uint stride) {
  Floats row = Floats(element(data, i, stride));
  return vec3(row.at[0], row.at[1], row.at[2]);
}

// As `Clip::shows`.
bool shows(vec3 mean) {
  for (uint k = 0u; k < seen.at[0].half_space_count; ++k) {
    const vec4 h = seen.at[0].half_spaces[k];
    FloatPair sum = add(two_product(h.x, mean.x), add(two_product(h.y, mean.y), add(two_product(h.z, mean.z), pair(h.w, 0.0))));
    if (!(sum.high >= 0.0)) return false;
  }
  const float radius = seen.at[0].clip_radius;
  if (!(radius <= 3.4e38)) return true;
  const vec3 from = mean - seen.at[0].clip_centre;
  return dot(from, from) <= radius * radius;
}

// Of any length: zeros are the identity.
vec4 normalised(vec4 q) {
  const float largest = max(max(abs(q.x), abs(q.y)), max(abs(q.z), abs(q.w)));
  if (largest == 0.0) return vec4(1.0, 0.0, 0.0, 0.0);
  const vec4 r = q / largest;
  const FloatPair squared = add(add(two_product(r.x, r.x), two_product(r.y, r.y)),
                                add(two_product(r.z, r.z), two_product(r.w, r.w)));
  const FloatPair inverse = inverse_root(squared);
  return vec4(times(pair(r.x, 0.0), inverse).high, times(pair(r.y, 0.0), inverse).high,
              times(pair(r.z, 0.0), inverse).high, times(pair(r.w, 0.0), inverse).high);
}

void main() {
  if (workgroup() * THREADS >= gaussians) return;
  const uint i = invocation();
  ProjectedShape shape;
  shape.visible = false;
  if (i < gaussians) {
    Gaussian g;
    g.mean = vector_at(seen.at[0].scene.means, i, seen.at[0].scene.means_stride);
    g.scale = vector_at(seen.at[0].scene.scales, i, seen.at[0].scene.scales_stride);
    Floats q = Floats(element(seen.at[0].scene.rotations, i, seen.at[0].scene.rotations_stride));
    g.rotation = vec4(q.at[0], q.at[1], q.at[2], q.at[3]);
    if (seen.at[0].scene.any_rotations != 0u) g.rotation = normalised(g.rotation);
    g.opacity = Floats(element(seen.at[0].scene.opacities, i, seen.at[0].scene.opacities_stride)).at[0];
    if (shows(g.mean)) shape = project_shape(seen.at[0].eye, g);
  }
  uint visible;
  const uint place = workgroup() * THREADS + sum_before(shape.visible ? 1u : 0u, visible);
  if (shape.visible) {
    projected.at[place].shape = shape.shape;
    projected.at[place].depth = shape.depth;
    projected.at[place].gaussian = i;
  }
  if (thread() == 0u) counts.at[workgroup()] = visible;
}
