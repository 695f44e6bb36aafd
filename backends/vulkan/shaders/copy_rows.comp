// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"

// Copies rows of floats, one a Gaussian, and activates numbers of training.
layout(push_constant, scalar) uniform Push {
  uvec2 from;
  Floats to;
  uint stride, width, kept, turn, count;
};

// The order of `Turn`.
const uint from_log = 1u, from_logit = 2u, turn_normalised = 3u, from_colour = 4u;

// Off by a unit in the last place: a power of two times the series of what is left.
float exp_of(float x) {
  if (!(x < 88.8)) return x > 0.0 ? uintBitsToFloat(0x7f800000u) : x;
  if (x < -104.0) return 0.0;
  const float whole = roundEven(x * 1.442695041), half_of_it = floor(0.5 * whole);
  precise float coarse = x - whole * 0.693359375;
  precise float r = coarse + whole * 2.12194440e-4;
  const float rest = ((((1.9875691500e-4 * r + 1.3981999507e-3) * r + 8.3334519073e-3) * r + 4.1665795894e-2) * r +
                      1.6666665459e-1) * r + 5.0000001201e-1;
  const float power = rest * (r * r) + r + 1.0;
  return power * exp2(half_of_it) * exp2(whole - half_of_it);
}

float activated(float x) {
  if (turn == from_log) return exp_of(x);
  if (turn == from_logit) return 1.0 / (1.0 + exp_of(-x));
  return turn == from_colour ? (x - 0.5) / 0.28209479177387814 : x;
}

void main() {
  const uint i = invocation();
  if (i >= count) return;
  Floats row = Floats(element(from, i, stride));
  Floats there = Floats(element(uvec2(to), i, 4u * kept));
  if (turn == turn_normalised) {
    const vec4 q = normalised(vec4(row.at[0], row.at[1], row.at[2], row.at[3]));
    for (uint k = 0u; k < 4u; ++k) there.at[k] = q[k];
  } else {
    for (uint k = 0u; k < kept; ++k) there.at[k] = k < width ? activated(row.at[k]) : 0.0;
  }
}
