// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"

// Empties the ranges of tiles; of a frame that overflowed they become those that no rasterizer draws. Also empties the
// launch over long lists, and finds from which length on lists are long: a part of all intersections, or `long_list`.
layout(push_constant, scalar) uniform Push {
  Uints ranges;
  uvec2 overflowed;
  Uints long_launch, long_tiles;
  Count count;
  uint tiles, long_list, long_part;
};

void main() {
  const uint i = invocation();
  if (i < 3u) long_launch.at[i] = i == 0u ? 0u : 1u;
  if (i == 0u) long_tiles.at[0] = max(long_list, number_of(count) / long_part);
  if (i >= tiles) return;
  const bool undrawn = !is_null(overflowed) && Uints(overflowed).at[0] != 0u;
  ranges.at[2u * i] = undrawn ? 1u : 0u;
  ranges.at[2u * i + 1u] = 0u;
}
