// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "pairs.glsl"

// Marks products whose rounding error `fma` does not give exactly.
layout(push_constant, scalar) uniform Push {
  Floats factors;
  Uints differs;
};

void main() {
  const uint i = invocation();
  const float a = factors.at[2u * i], b = factors.at[2u * i + 1u];
  const FloatPair product = split_product(a, b);
  precise float low = fma(a, b, -product.high);
  differs.at[i] = low == product.low ? 0u : 1u;
}
