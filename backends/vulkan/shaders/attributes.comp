// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"
#include "attributes.glsl"

// Gathers rows of attributes of splats, as `SplatAttributes` does. Depths along the ray are there with ALONG_RAY.

layout(push_constant, scalar) uniform Push {
  Seens seen;  // by view, then by placed scene
  Shapes shapes;
  Uints gaussians;
  uvec2 of_view;
  Floats depths;
  AttributeLists lists;  // of the views
  Floats to;
  Count count;
  uint scenes;
};

// As `splat_normal`.
vec3 normal_of(Eye eye, Gaussian g) {
  const LocalAxes axes = local_axes(g.rotation);
  const uint first = g.scale.y < g.scale.x ? 1u : 0u;
  const uint shortest = g.scale.z < g.scale[first] ? 2u : first;
  PairVector axis = axes.x;
  if (shortest == 1u) axis = axes.y;
  if (shortest == 2u) axis = axes.z;
  const vec3 world = vec3(axis.x.high, axis.y.high, axis.z.high);
  vec3 normal;
  for (uint row = 0u; row < 3u; ++row)
    normal[row] = dot(vec3(eye.rotation[3u * row].high, eye.rotation[3u * row + 1u].high, eye.rotation[3u * row + 2u].high),
                      world);
  const PairVector ray = to_camera(eye, g.mean);
  const bool away =
      eye.lens == orthographic ? normal.z > 0.0 : dot(normal, vec3(ray.x.high, ray.y.high, ray.z.high)) > 0.0;
  return away ? -normal : normal;
}

// As `RayDepth::square`.
float square(vec3 d, uint k) {
  const float with[6] = float[6](d.x, 2.0 * d.y, 2.0 * d.z, d.y, 2.0 * d.z, d.z);
  const float of[6] = float[6](d.x, d.x, d.x, d.y, d.y, d.z);
  return with[k] * of[k];
}

void main() {
  const uint i = invocation();
  if (i >= number_of(count)) return;
  const uint view = view_at(of_view, i), of = seen_by(seen, scenes, view, gaussians.at[i]);
  const uint g = gaussians.at[i] - seen.at[of].first_gaussian;
  const float most = lists.at[view].most;
  Floats features = Floats(element(seen.at[of].scene.features, g, seen.at[of].scene.features_stride));
  const Eye eye = seen.at[of].eye;
  const Gaussian drawn = gaussian_of(seen.at[of].scene, g);
  const float depth = drawn_depth(eye, drawn.mean, depths.at[i]);
  vec3 normal = vec3(0.0), along_ray = vec3(0.0);
  if (lists.at[view].has_normal != 0u) normal = normal_of(eye, drawn);
#ifdef ALONG_RAY
  if (lists.at[view].has_ray_depth != 0u) along_ray = ray_depth(eye, drawn, shape_of(shapes.at[i]), depth, most);
#endif
  const uint attributes = lists.at[view].count;
  Floats row = Floats(element(uvec2(to), i, 4u * attributes));
  for (uint k = 0u; k < attributes; ++k) {
    const Attribute from = lists.at[view].each[k];
    float value = 0.0;
    if (from.of == of_ray_depth) value = along_ray[from.channel];
    if (from.of == of_normal) value = normal[from.channel];
    if (from.of == of_squared_depth) value = min(depth * depth, most);
    if (from.of == of_squared_ray_depth) value = square(along_ray, from.channel);
    if (from.of == of_feature) value = features.at[from.channel];
    // A number that is not finite counts as 0.
    row.at[k] = abs(value) <= 3.4028234663852886e38 ? clamp(value, -most, most) : 0.0;
  }
}
