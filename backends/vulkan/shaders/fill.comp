// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"

// Fills words with a value.
layout(push_constant, scalar) uniform Push {
  Uints to;
  uint count, value;
};

void main() {
  const uint i = invocation();
  if (i < count) to.at[i] = value;
}
