// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "common.glsl"
#include "frame.glsl"
#include "pixels.glsl"
#include "image.glsl"

layout(constant_id = 3) const bool DEPTH = false;

// Copies colours from an image, or depths.
layout(set = 0, binding = 1) uniform texture2D image;

void main() {
  const uint i = invocation();
  if (i >= width * height) return;
  const uvec2 at = uvec2(i % width, i / width);
  const vec4 pixel = texelFetch(image, ivec2(at), 0);
  if (DEPTH) floats_of(plane, at, 1u).at[0] = pixel.r;
  else store_colour(as_view(), at, pixel);
}
