// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"
#include "pixels.glsl"
#include "image.glsl"

// Copies pixels to an image.
layout(set = 0, binding = 0) uniform writeonly image2D image;

void main() {
  const uint i = invocation();
  if (i >= width * height) return;
  const uvec2 at = uvec2(i % width, i / width);
  imageStore(image, ivec2(at), load_colour(as_view(), at));
}
