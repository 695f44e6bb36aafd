// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "pairs.glsl"

// Finds out what the device's arithmetic promises beyond Vulkan: sets a bit of `lacks` for each promise that fails.
layout(push_constant, scalar) uniform Push {
  Floats factors;
  Uints lacks;
};

void main() {
  const uint i = invocation();
  const float a = factors.at[2u * i], b = factors.at[2u * i + 1u];
  // `fma` gives the rounding error of a product exactly.
  const FloatPair product = split_product(a, b);
  precise float low = fma(a, b, -product.high);
  // `exp2` is within 2.5 units in the last place, down to a faint alpha.
  const float s = 12.0 * (a - 1.0), exact = exp2_negative(s);
  lacks.at[i] = (low == product.low ? 0u : 1u) | (abs(exp2(-s) - exact) <= 3e-7 * exact ? 0u : 2u);
}
