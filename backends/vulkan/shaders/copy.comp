// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"

// Copies words.
layout(push_constant, scalar) uniform Push {
  Uints from, to;
  uint count;
};

void main() {
  const uint i = invocation();
  if (i < count) to.at[i] = from.at[i];
}
