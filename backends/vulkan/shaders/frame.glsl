// SPDX-License-Identifier: Apache-2.0

// What kernels of a frame read and write.

#include "pairs.glsl"
#include "project.glsl"
#include "bounds.glsl"

// Arrays of a scene: `SceneView`.
struct SceneArrays {
  uvec2 means, scales, rotations, opacities, sh0, sh_rest, labels;
  uint means_stride, scales_stride, rotations_stride, opacities_stride, sh0_stride, sh_stride;
  uint sh_format;  // as `HarmonicFormat`
  float sh_scale;
  uint sh_degree, any_rotations, plain_colours;
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
};
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Seens { Seen at[]; };

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Shapes { Shape at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Footprints { uvec4 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Colours { vec4 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Grids { TileGrid at[]; };

// A visible Gaussian before its splat has a place.
struct Projected {
  Shape shape;
  float depth;
  uint gaussian;  // in its scene
};
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Projecteds { Projected at[]; };

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
