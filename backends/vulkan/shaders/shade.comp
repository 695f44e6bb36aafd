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
  Uints colourless;
  Count count;
  uint scenes, first;  // splat of this launch
};

const float LARGEST = 3.4028234663852886e38;

// Coefficients above band 0 of this thread's Gaussian. All loads are under way before the first is needed.
const uint MOST = 45u;
float rest[MOST];

// Reads a `HarmonicRow` of `count` words, by quadruples where `whole`.
void load_rest(uvec2 row, uint count, bool whole, uint format, float scale) {
  uint words[MOST + 3u];
  if (whole) {
    [[unroll]] for (uint k = 0u; k < MOST; k += 4u) {
      const uvec4 four = k < count ? Fours(row).at[k / 4u] : uvec4(0u);
      [[unroll]] for (uint i = 0u; i < 4u; ++i) words[k + i] = four[i];
    }
  } else {
    [[unroll]] for (uint k = 0u; k < MOST; ++k) words[k] = k < count ? Uints(row).at[k] : 0u;
  }
  if (format == 0u) {
    [[unroll]] for (uint k = 0u; k < MOST; ++k) rest[k] = uintBitsToFloat(words[k]);
  } else if (format == 1u) {
    [[unroll]] for (uint k = 0u; k < MOST; ++k) rest[k] = unpackHalf2x16(words[k / 2u])[k & 1u];
  } else {
    [[unroll]] for (uint k = 0u; k < MOST; ++k)
      rest[k] = scale * float(bitfieldExtract(int(words[k / 4u]), int(8u * (k & 3u)), 8));
  }
}
vec3 coefficients(uint k) { return vec3(rest[3u * k], rest[3u * k + 1u], rest[3u * k + 2u]); }

// In units of `unit`, where terms of the usual unit leave the range of float.
vec3 colour_of(uint degree, vec3 sh0, vec3 d, float unit) {
  vec3 c = vec3(0.5 * unit) + 0.28209479177387814 * (unit * sh0);
  if (degree < 1u) return c;
  const float x = d.x, y = d.y, z = d.z;
  c += -0.4886025119029199 * y * (unit * coefficients(0u));
  c += 0.4886025119029199 * z * (unit * coefficients(1u));
  c += -0.4886025119029199 * x * (unit * coefficients(2u));
  if (degree < 2u) return c;
  const float xx = x * x, yy = y * y, zz = z * z;
  c += 1.0925484305920792 * x * y * (unit * coefficients(3u));
  c += -1.0925484305920792 * y * z * (unit * coefficients(4u));
  c += 0.31539156525252005 * (2.0 * zz - xx - yy) * (unit * coefficients(5u));
  c += -1.0925484305920792 * x * z * (unit * coefficients(6u));
  c += 0.5462742152960396 * (xx - yy) * (unit * coefficients(7u));
  if (degree < 3u) return c;
  c += -0.5900435899266435 * y * (3.0 * xx - yy) * (unit * coefficients(8u));
  c += 2.890611442640554 * x * y * z * (unit * coefficients(9u));
  c += -0.4570457994644658 * y * (4.0 * zz - xx - yy) * (unit * coefficients(10u));
  c += 0.3731763325901154 * z * (2.0 * zz - 3.0 * xx - 3.0 * yy) * (unit * coefficients(11u));
  c += -0.4570457994644658 * x * (4.0 * zz - xx - yy) * (unit * coefficients(12u));
  c += 1.445305721320277 * z * (xx - yy) * (unit * coefficients(13u));
  c += -0.5900435899266435 * x * (xx - 3.0 * yy) * (unit * coefficients(14u));
  return c;
}

bool is_finite(vec3 c) { return all(lessThanEqual(abs(c), vec3(LARGEST))); }

void main() {
  const uint i = first + invocation();
  if (i >= number_of(count)) return;
  const uint of = seen_by(seen, scenes, view_at(of_view, i), gaussians.at[i]);
  const uint g = gaussians.at[i] - seen.at[of].first_gaussian;
  const SceneArrays scene = seen.at[of].scene;
  const uint number = is_null(scene.labels) ? g : half_word(scene.labels, g);
  const uint degree = scene.sh_degree, numbers = 3u * (degree * degree + 2u * degree);
  const uint shift = scene.sh_format;  // a word holds 1, 2 or 4 numbers
  // The last row may lack its padding, so it is read word by word.
  const bool whole = ((scene.sh_rest.x | scene.sh_stride) & 15u) == 0u && number + 1u < scene.sh_rows;
  load_rest(element(scene.sh_rest, number, scene.sh_stride), (numbers + (1u << shift) - 1u) >> shift, whole,
            scene.sh_format, scene.sh_scale);
  vec3 sh0 = vector_at(scene.sh0, g, scene.sh0_stride);
  if (scene.plain_colours != 0u) sh0 = (sh0 - 0.5) / 0.28209479177387814;

  const vec3 mean = vector_at(scene.means, g, scene.means_stride);
  const vec3 direction = view_direction(seen.at[of].eye, mean);
  vec3 colour = colour_of(scene.sh_degree, sh0, direction, 1.0);
  if (!is_finite(colour)) colour = colour_of(scene.sh_degree, sh0, direction, 0.015625) / 0.015625;
  if (!is_finite(colour)) {
    colourless.at[0] = 1u;
    colours.at[i] = vec4(0.0);
    return;
  }
  colour = max(colour, vec3(0.0));
  const float amount = seen.at[of].tint_amount;
  if (amount != 0.0) colour = min(amount * seen.at[of].tint + (1.0 - amount) * colour, vec3(LARGEST));
  colours.at[i] = vec4(colour, drawn_depth(seen.at[of].eye, mean, depths.at[i]));
}
