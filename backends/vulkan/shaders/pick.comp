// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"
#include "pixels.glsl"
#include "alpha.glsl"

// Picks at the pixels of a rectangle, as `PickPixel` does.
layout(set = 1, binding = 0, scalar) uniform Constants { RasterView view; };
layout(push_constant, scalar) uniform Push {
  Shapes shapes;
  Colours colours;
  Uints gaussians, ids, ranges;
  uvec2 to;  // the first of the rectangle's `PickedPixel`s, of 20 bytes
  uint x, y, width, height, pitch;
};

const uint NONE = 0xffffffffu;

void main() {
  const uint i = invocation();
  if (i >= width * height) return;
  const TileGrid grid = view.grid;
  const ivec2 pixel = ivec2(grid.first_column, grid.first_row) * grid.side + ivec2(x + i % width, y + i / width);
  const uint tile = tile_number(grid, pixel.x / grid.side, pixel.y / grid.side);
  const uint begin = ranges.at[2u * tile], end = ranges.at[2u * tile + 1u];

  float transmittance = 1.0, largest = 0.0, depth = 0.0, median_depth = 0.0;
  uint gaussian = NONE, median = NONE;
  bool found = false;
  // Sixteen splats a round: lavapipe ends a loop after 65,535 rounds.
  for (uint from = begin; from < end && !found; from += 16u)
    [[unroll]] for (uint k = 0u; k < 16u; ++k)
      if (from + k < end && !found) {
        const uint id = ids.at[from + k];
        const float of_splat = colours.at[id].w;
        float alpha = 0.0;
        if (of_splat > 0.0)
          alpha = alpha_of(terms_of(shape_of(shapes.at[id]), vec2(pixel) + 0.5, view.alpha_max), vec2(0.0), view.least);
        if (alpha != 0.0) {
          const float weight = alpha * transmittance, next = dimmed(transmittance, alpha, weight, view.alpha_max);
          found = next < view.stop_below;
          if (!found && weight > largest) {
            gaussian = gaussians.at[id];
            largest = weight;
            depth = of_splat;
          }
          if (!found && transmittance >= 0.5 && next < 0.5) {
            median = gaussians.at[id];
            median_depth = of_splat;
          }
          transmittance = next;
          found = found || (next < 0.5 && next <= largest);  // no later splat weighs more
        }
      }

  const uvec2 row = element(to, i / width, 20u * pitch);
  Uints picked = Uints(element(row, i % width, 20u));
  picked.at[0] = gaussian;
  picked.at[1] = floatBitsToUint(view.alpha_max * largest);
  picked.at[2] = floatBitsToUint(depth);
  picked.at[3] = median;
  picked.at[4] = floatBitsToUint(median_depth);
}
