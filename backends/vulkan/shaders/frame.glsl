// SPDX-License-Identifier: Apache-2.0

// What kernels of a frame read and write.

#include "pairs.glsl"
#include "project.glsl"
#include "lens.glsl"
#include "bounds.glsl"
#include "lens_box.glsl"
#include "chunks.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Chunks { Chunk at[]; };

// Arrays of a scene: `SceneView`.
struct SceneArrays {
  uvec2 means, scales, rotations, opacities, sh0, sh_rest, labels, features, chunks;
  uint means_stride, scales_stride, rotations_stride, opacities_stride, sh0_stride, sh_stride, features_stride;
  uint sh_format;  // as `HarmonicFormat`
  float sh_scale;
  uint sh_rows, sh_degree, any_rotations, plain_colours;
};

// A placed scene and the eye that sees it: `Seen` of the host.
struct Seen {
  Eye eye;
  SceneArrays scene;
  vec4 half_spaces[6];
  uint half_space_count;
  vec3 clip_centre;
  float clip_radius;
  vec3 tint;
  float tint_amount;
  uint first_gaussian;
  Culler culler;
  uint unused[2];  // to 16 bytes, so that a device loads several words at once
};
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Seens { Seen at[]; };

// The scene of a Gaussian as a view sees it, of all scenes by all views.
uint seen_by(Seens seen, uint scenes, uint view, uint gaussian) {
  uint low = view * scenes, high = low + scenes;
  while (high - low > 1u) {
    const uint middle = low + (high - low) / 2u;
    if (seen.at[middle].first_gaussian <= gaussian) low = middle;
    else high = middle;
  }
  return low;
}

vec3 vector_at(uvec2 data, uint i, uint stride) {
  Floats row = Floats(element(data, i, stride));
  return vec3(row.at[0], row.at[1], row.at[2]);
}

// `x` times 2^100, also on devices that take denormal numbers for zeros.
float times_2_to_100(float x) {
  const uint bits = floatBitsToUint(x), mantissa = bits & 0x7fffffu;
  if ((bits & 0x7f800000u) != 0u) return x * 1.2676506002282294e30;
  return ((bits >> 31u) != 0u ? -1.7763568394002505e-15 : 1.7763568394002505e-15) * float(mantissa);
}

// Of any length: zeros are the identity.
vec4 normalised(vec4 q) {
  const uvec4 sizes = floatBitsToUint(q) & 0x7fffffffu;  // they ascend with the magnitudes
  const uint most = max(max(sizes.x, sizes.y), max(sizes.z, sizes.w));
  if (most == 0u) return vec4(1.0, 0.0, 0.0, 0.0);
  // First to where a power of two and its inverse are normal numbers.
  if (most < 0x20000000u)  // 2^-63
    q = vec4(times_2_to_100(q.x), times_2_to_100(q.y), times_2_to_100(q.z), times_2_to_100(q.w));
  else if (most > 0x5f000000u)  // 2^63
    q *= 7.888609052210118e-31;
  const float largest = max(max(abs(q.x), abs(q.y)), max(abs(q.z), abs(q.w)));
  const vec4 r = q * uintBitsToFloat(0x7f000000u - (floatBitsToUint(largest) & 0x7f800000u));  // exact
  const FloatPair squared = add(add(two_product(r.x, r.x), two_product(r.y, r.y)),
                                add(two_product(r.z, r.z), two_product(r.w, r.w)));
  const FloatPair inverse = inverse_root(squared);
  return vec4(times(pair(r.x, 0.0), inverse).high, times(pair(r.y, 0.0), inverse).high,
              times(pair(r.z, 0.0), inverse).high, times(pair(r.w, 0.0), inverse).high);
}

Gaussian gaussian_of(SceneArrays scene, uint i) {
  Gaussian g;
  g.mean = vector_at(scene.means, i, scene.means_stride);
  g.scale = vector_at(scene.scales, i, scene.scales_stride);
  Floats q = Floats(element(scene.rotations, i, scene.rotations_stride));
  g.rotation = vec4(q.at[0], q.at[1], q.at[2], q.at[3]);
  if (scene.any_rotations != 0u) g.rotation = normalised(g.rotation);
  g.opacity = Floats(element(scene.opacities, i, scene.opacities_stride)).at[0];
  return g;
}

// Arrays that stages share have vectors of 16 bytes, which a device loads and stores at once.
struct ShapeWords {
  vec4 first, second;
};
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer Shapes { ShapeWords at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer Footprints { uvec4 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer Colours { vec4 at[]; };

Shape shape_of(ShapeWords words) {
  const vec4 a = words.first, b = words.second;
  return Shape(a.xy, a.z, a.w, b.x, b.y, b.z, floatBitsToUint(b.w));
}
ShapeWords stored_shape(Shape s) {
  return ShapeWords(vec4(s.mean, s.l0, s.l1), vec4(s.l2, s.opacity, s.cutoff, uintBitsToFloat(s.low)));
}
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Grids { TileGrid at[]; };

// Bits of the depth of a visible Gaussian, whose splat has no place yet, and its number in its scene.
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer Projecteds { uvec2 at[]; };

// `FrameTotals` of the host: 64-bit numbers by halves.
struct Totals {
  uvec2 visible, intersections, overflowed;
  uint splats, kept_intersections;
};
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer TotalsAt { Totals totals; };

// Word `i` of 16 bits.
uint half_word(uvec2 address, uint i) {
  const uvec2 at = element(address, i, 2u);
  return (Uints(uvec2(at.x & ~3u, at.y)).at[0] >> (8u * (at.x & 2u))) & 0xffffu;
}
uint view_at(uvec2 of_view, uint i) { return is_null(of_view) ? 0u : half_word(of_view, i); }
