// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"

// Evaluates the colours of splats: the only kernel that reads spherical harmonics.
layout(push_constant, scalar) uniform Push {
  Seens seen;            // by view, then by placed scene
  Uints gaussians;
  uvec2 of_view;
  Floats depths;
  Colours colours;
  Uints hidden;
  Count count;
  uint scenes, first;  // splat of this launch
};

const float LARGEST = 3.4028234663852886e38;

// Coefficients above band 0 of the Gaussians of a workgroup, as `HarmonicRow`. A subgroup copies a row at a time, whose
// words lie next to each other in memory.
const uint MOST_WORDS = 45u;
shared uint words[THREADS * MOST_WORDS];

void copy_rows(uvec2 row, uint count) {
  [[unroll]] for (uint r = 0u; r < SUBGROUP; ++r) {
    Uints from = Uints(uvec2(subgroupShuffle(row.x, r), subgroupShuffle(row.y, r)));
    const uint of_row = subgroupShuffle(count, r), to = (gl_SubgroupID * SUBGROUP + r) * MOST_WORDS;
    for (uint w = gl_SubgroupInvocationID; w < of_row; w += SUBGROUP) words[to + w] = from.at[w];
  }
  share_in_subgroup();
}

// How a row holds numbers.
struct Row {
  uint format;
  float scale;
};
float coefficient(Row row, uint k) {
  const uint first = thread() * MOST_WORDS;
  if (row.format == 0u) return uintBitsToFloat(words[first + k]);
  if (row.format == 1u) {
    const vec2 two = unpackHalf2x16(words[first + k / 2u]);
    return (k & 1u) == 0u ? two.x : two.y;
  }
  return row.scale * float(bitfieldExtract(int(words[first + k / 4u]), int(8u * (k & 3u)), 8));
}
vec3 coefficients(Row row, uint k) {
  return vec3(coefficient(row, 3u * k), coefficient(row, 3u * k + 1u), coefficient(row, 3u * k + 2u));
}

// In units of `unit`, where terms of the usual unit leave the range of float.
vec3 colour_of(uint degree, vec3 sh0, Row row, vec3 d, float unit) {
  vec3 c = vec3(0.5 * unit) + 0.28209479177387814 * (unit * sh0);
  if (degree < 1u) return c;
  const float x = d.x, y = d.y, z = d.z;
  c += -0.4886025119029199 * y * (unit * coefficients(row, 0u));
  c += 0.4886025119029199 * z * (unit * coefficients(row, 1u));
  c += -0.4886025119029199 * x * (unit * coefficients(row, 2u));
  if (degree < 2u) return c;
  const float xx = x * x, yy = y * y, zz = z * z;
  c += 1.0925484305920792 * x * y * (unit * coefficients(row, 3u));
  c += -1.0925484305920792 * y * z * (unit * coefficients(row, 4u));
  c += 0.31539156525252005 * (2.0 * zz - xx - yy) * (unit * coefficients(row, 5u));
  c += -1.0925484305920792 * x * z * (unit * coefficients(row, 6u));
  c += 0.5462742152960396 * (xx - yy) * (unit * coefficients(row, 7u));
  if (degree < 3u) return c;
  c += -0.5900435899266435 * y * (3.0 * xx - yy) * (unit * coefficients(row, 8u));
  c += 2.890611442640554 * x * y * z * (unit * coefficients(row, 9u));
  c += -0.4570457994644658 * y * (4.0 * zz - xx - yy) * (unit * coefficients(row, 10u));
  c += 0.3731763325901154 * z * (2.0 * zz - 3.0 * xx - 3.0 * yy) * (unit * coefficients(row, 11u));
  c += -0.4570457994644658 * x * (4.0 * zz - xx - yy) * (unit * coefficients(row, 12u));
  c += 1.445305721320277 * z * (xx - yy) * (unit * coefficients(row, 13u));
  c += -0.5900435899266435 * x * (xx - 3.0 * yy) * (unit * coefficients(row, 14u));
  return c;
}

bool is_finite(vec3 c) { return all(lessThanEqual(abs(c), vec3(LARGEST))); }

void main() {
  const uint i = first + invocation();
  const bool some = i < number_of(count);
  uint of = 0u, g = 0u, row_words = 0u;
  uvec2 row_at = uvec2(0u);
  if (some) {
    of = seen_by(seen, scenes, view_at(of_view, i), gaussians.at[i]);
    g = gaussians.at[i] - seen.at[of].first_gaussian;
    const uint number = is_null(seen.at[of].scene.labels) ? g : half_word(seen.at[of].scene.labels, g);
    const uint degree = seen.at[of].scene.sh_degree, numbers = 3u * (degree * degree + 2u * degree);
    const uint shift = seen.at[of].scene.sh_format;  // a word holds 1, 2 or 4 numbers
    row_words = (numbers + (1u << shift) - 1u) >> shift;
    row_at = element(seen.at[of].scene.sh_rest, number, seen.at[of].scene.sh_stride);
  }
  copy_rows(row_at, row_words);
  if (!some) return;
  const SceneArrays scene = seen.at[of].scene;
  vec3 sh0 = vector_at(scene.sh0, g, scene.sh0_stride);
  if (scene.plain_colours != 0u) sh0 = (sh0 - 0.5) / 0.28209479177387814;
  const Row row = Row(scene.sh_format, scene.sh_scale);

  const vec3 mean = vector_at(scene.means, g, scene.means_stride);
  const vec3 direction = view_direction(seen.at[of].eye, mean);
  vec3 colour = colour_of(scene.sh_degree, sh0, row, direction, 1.0);
  if (!is_finite(colour)) colour = colour_of(scene.sh_degree, sh0, row, direction, 0.015625) / 0.015625;
  if (!is_finite(colour)) {
    hidden.at[0] = 1u;
    colours.at[i] = vec4(0.0);
    return;
  }
  colour = max(colour, vec3(0.0));
  const float amount = seen.at[of].tint_amount;
  if (amount != 0.0) colour = min(amount * seen.at[of].tint + (1.0 - amount) * colour, vec3(LARGEST));
  colours.at[i] = vec4(colour, drawn_depth(seen.at[of].eye, mean, depths.at[i]));
}
