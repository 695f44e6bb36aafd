// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"
#include "attributes.glsl"
#include "pixels.glsl"

// Blends the splats of a warp block of 8x8 pixels, which a subgroup shares: each lane has every SUBGROUP-th pixel. It
// tests a splat a lane against the block, then blends the splats that touch it, one after the other.

// The exponent representation, and whether pixels compare the exponent with the splat's cutoff.
const uint half_split = 0u, float_split = 1u, float_cholesky = 2u;
layout(constant_id = 2) const uint EXPONENT = float_cholesky;
layout(constant_id = 3) const bool THRESHOLD = true;
// What the view asks for beside colour and alpha.
layout(constant_id = 4) const bool DEPTH = false;
layout(constant_id = 5) const bool PICKS = false;
layout(constant_id = 6) const bool OCCLUDER = false;
layout(constant_id = 7) const bool CONVERTS = false;
// Most attributes of a pass, and whether it draws all other planes too. Loops over attributes count to a number in memory:
// unrolled by each pixel they would take a minute to compile.
layout(constant_id = 8) const uint ATTRIBUTES = 0u;
layout(constant_id = 9) const bool IS_BASE = true;

layout(push_constant, scalar) uniform Push {
  RasterViews views;  // this view alone
  Shapes shapes;
  Colours colours;
  Uints gaussians, ids, ranges;
  AttributeLists attributes_of;  // this view alone
  Floats attributes;
};

const uint SIDE = 8u, EACH = SIDE * SIDE / SUBGROUP;
const uint NONE = 0xffffffffu, SUMS = ATTRIBUTES == 0u ? 1u : ATTRIBUTES;

// Place of pixel `p` of this lane in the block.
uvec2 place_of(uint p) {
  const uint n = p * SUBGROUP + gl_SubgroupInvocationID;
  return uvec2(n % SIDE, n / SIDE);
}

// 2^-s for s >= 0, a unit in the last place, by the series of the remainder of an integer.
float exp2_negative(float s) {
  const float whole = roundEven(s);
  if (!(whole <= 126.0)) return 0.0;
  precise float x = whole - s;
  precise float p6 = x * 1.540353039e-4;
  precise float p5 = p6 + 1.333355815e-3;
  precise float t5 = x * p5;
  precise float p4 = t5 + 9.618129108e-3;
  precise float t4 = x * p4;
  precise float p3 = t4 + 5.550410866e-2;
  precise float t3 = x * p3;
  precise float p2 = t3 + 2.402265070e-1;
  precise float t2 = x * p2;
  precise float p1 = t2 + 6.931471806e-1;
  precise float t1 = x * p1;
  precise float p0 = t1 + 1.0;
  return p0 * uintBitsToFloat((127u - uint(whole)) << 23);
}

// As `box_touched` of `Cuda`: whether the ellipse s <= cutoff meets the box of the block's pixel centres.
bool box_touched(Shape s, vec2 first) {
  const float left = right_of_mean(s, first.x), right = left + float(SIDE - 1u);
  const float top = below_mean(s, first.y), bottom = top + float(SIDE - 1u);
  const float nearest_y = min(max(0.0, top), bottom);
  const float u_left = s.l0 * left + s.l1 * nearest_y, u_right = s.l0 * right + s.l1 * nearest_y;
  const float edge = u_left > 0.0 ? left : right;
  const float along_edge = -s.l0 * s.l1 * edge / (s.l1 * s.l1 + s.l2 * s.l2);
  const bool across = u_left <= 0.0 && u_right >= 0.0;
  const float y = across ? nearest_y : min(max(along_edge, top), bottom);
  const float u = across ? 0.0 : s.l0 * edge + s.l1 * y, v = s.l2 * y;
  return u * u + v * v <= s.cutoff * 1.0001;
}

// Terms of `FloatSplit`, measured from the centre of the raster block.
struct Split {
  float a, b, c, d, e, g;
};
Split split_of(Shape s, vec2 centre) {
  precise float x = right_of_mean(s, centre.x);
  precise float y = below_mean(s, centre.y);
  precise float u = s.l0 * x + s.l1 * y;
  precise float v = s.l2 * y;
  precise float a = s.l0 * s.l0;
  precise float b = 2.0 * s.l0 * s.l1;
  precise float c = s.l1 * s.l1 + s.l2 * s.l2;
  precise float d = 2.0 * s.l0 * u;
  precise float e = 2.0 * (s.l1 * u + s.l2 * v);
  precise float g = u * u + v * v;
  return Split(a, b, c, d, e, g);
}

float exponent_of(Shape s, Split split, vec2 centre, vec2 at) {
  if (EXPONENT == float_split) {
    const float x = at.x - centre.x, y = at.y - centre.y;
    precise float of_x = (split.a * x + split.d) * x;
    precise float of_y = (split.c * y + split.e) * y + split.g;
    precise float mixed = split.b * x;
    precise float exponent = of_x + of_y + mixed * y;
    return exponent < 0.0 ? 0.0 : exponent;
  }
  const float dx = right_of_mean(s, at.x), dy = below_mean(s, at.y);
  if (EXPONENT == half_split) {
    precise float of_x = s.l0 * s.l0 * dx * dx;
    precise float mixed = 2.0 * s.l0 * s.l1 * dx;
    precise float of_y = (s.l1 * s.l1 + s.l2 * s.l2) * dy * dy;
    precise float exponent = from_half(to_half(of_x)) + from_half(to_half(of_y)) +
                             from_half(to_half(mixed)) * from_half(to_half(dy));
    return exponent;
  }
  precise float p = s.l0 * dx;
  precise float q = s.l1 * dy;
  precise float u = p + q;
  precise float v = s.l2 * dy;
  precise float uu = u * u;
  precise float vv = v * v;
  precise float exponent = uu + vv;
  return exponent;
}

// 0 where the pixel skips the splat.
float alpha_of(Shape s, float exponent, RasterView view) {
  if (!(exponent >= 0.0) || (THRESHOLD && !(exponent <= s.cutoff))) return 0.0;
  precise float alpha = s.opacity * exp2_negative(exponent);
  if (!THRESHOLD && !(alpha >= view.alpha_min)) return 0.0;
  return min(alpha, view.alpha_max);
}

float dimmed(float transmittance, float alpha) {
  precise float left = 1.0 - alpha;
  precise float by_rest = transmittance * left;
  precise float taken = alpha * transmittance;
  precise float by_taken = transmittance - taken;
  return alpha > 0.5 ? by_rest : by_taken;
}

void main() {
  const RasterView view = views.at[0];
  const TileGrid grid = view.grid;
  const uvec2 block = gl_WorkGroupID.xy * SIDE;
  const ivec2 first_pixel = ivec2(grid.first_column, grid.first_row) * grid.side + ivec2(block);
  const vec2 first_centre = vec2(first_pixel) + 0.5;
  const vec2 raster_centre = vec2(first_pixel - ivec2(block & 8u)) + 8.0;
  const uint tile = tile_number(grid, first_pixel.x / grid.side, first_pixel.y / grid.side);
  const uint begin = ranges.at[2u * tile], end = ranges.at[2u * tile + 1u];
  if (begin > end) return;  // as of `TileRange::undrawn`

  float transmittance[EACH], depth[EACH], weight_of_largest[EACH], occluded_from[EACH];
  vec3 colour[EACH];
  float sums[EACH * SUMS];
  uint first[EACH], median[EACH], largest[EACH];
  bool stopped[EACH];
  bool all_stopped = true;
  for (uint p = 0u; p < EACH; ++p) {
    const uvec2 at = block + place_of(p);
    const bool inside = at.x < view.width && at.y < view.height;
    transmittance[p] = 1.0;
    colour[p] = vec3(0.0);
    if (ATTRIBUTES != 0u)
      for (uint k = 0u; k < attributes_of.at[0].count; ++k) sums[p * SUMS + k] = 0.0;
    depth[p] = 0.0;
    first[p] = median[p] = largest[p] = NONE;
    weight_of_largest[p] = 0.0;
    stopped[p] = !inside;
    all_stopped = all_stopped && !inside;
    occluded_from[p] = OCCLUDER && inside ? occluder_at(view, at) : 0.0;
  }

  for (uint from = begin; from < end && !subgroupAll(all_stopped); from += SUBGROUP) {
    const uint i = from + gl_SubgroupInvocationID;
    const uint mine = ids.at[i < end ? i : begin];
    const Shape shape = shapes.at[mine];
    const vec4 of_mine = colours.at[mine];
    uvec4 touching = subgroupBallot(i < end && of_mine.w > 0.0 && box_touched(shape, first_centre));
    while ((touching.x | touching.y) != 0u) {
      const uint lane = touching.x != 0u ? uint(findLSB(touching.x)) : 32u + uint(findLSB(touching.y));
      if (touching.x != 0u) touching.x &= touching.x - 1u;
      else touching.y &= touching.y - 1u;
      Shape s;
      s.mean = subgroupShuffle(shape.mean, lane);
      s.l0 = subgroupShuffle(shape.l0, lane);
      s.l1 = subgroupShuffle(shape.l1, lane);
      s.l2 = subgroupShuffle(shape.l2, lane);
      s.opacity = subgroupShuffle(shape.opacity, lane);
      s.cutoff = subgroupShuffle(shape.cutoff, lane);
      s.low = subgroupShuffle(shape.low, lane);
      const vec4 rgb_depth = subgroupShuffle(of_mine, lane);
      const uint id = PICKS || ATTRIBUTES != 0u ? subgroupShuffle(mine, lane) : NONE;
      Split split;
      if (EXPONENT == float_split) split = split_of(s, raster_centre);
      all_stopped = true;
      for (uint p = 0u; p < EACH; ++p) {
        const vec2 at = first_centre + vec2(place_of(p));
        const float alpha = alpha_of(s, exponent_of(s, split, raster_centre, at), view);
        if (!stopped[p] && alpha != 0.0) {
          const float next = dimmed(transmittance[p], alpha);
          if (next < view.stop_below || (OCCLUDER && rgb_depth.w >= occluded_from[p])) {
            stopped[p] = true;
          } else {
            precise float weight = alpha * transmittance[p];
            precise vec3 more = weight * rgb_depth.rgb;
            precise vec3 sum = colour[p] + more;
            colour[p] = sum;
            if (DEPTH) depth[p] += weight * rgb_depth.w;
            if (ATTRIBUTES != 0u)
              for (uint k = 0u; k < attributes_of.at[0].count; ++k)
                sums[p * SUMS + k] += weight * attributes.at[id * ATTRIBUTES + k];
            transmittance[p] = next;
            if (PICKS) {
              if (weight > weight_of_largest[p]) {
                largest[p] = id;
                weight_of_largest[p] = weight;
              }
              if (first[p] == NONE && next < view.first_below) first[p] = id;
              if (median[p] == NONE && next < 0.5) median[p] = id;
            }
          }
        }
        all_stopped = all_stopped && stopped[p];
      }
    }
  }

  for (uint p = 0u; p < EACH; ++p) {
    const uvec2 at = block + place_of(p);
    if (at.x >= view.width || at.y >= view.height) continue;
    precise float alpha = 1.0 - transmittance[p];
    for (uint k = 0u; ATTRIBUTES != 0u && k < attributes_of.at[0].count; ++k) {
      const Attribute to = attributes_of.at[0].each[k];
      const float sum = sums[p * SUMS + k];
      if (to.of == of_normal) floats_of(view.normal, at, 3u).at[to.channel] = sum;
      if (to.of == of_squared_depth) floats_of(view.squared_depth, at, 1u).at[0] = alpha > 0.0 ? sum / alpha : 0.0;
      if (to.of == of_feature) floats_of(view.features, at, view.feature_channels).at[to.channel] = sum;
    }
    if (!IS_BASE) continue;
    if (!is_null(view.colour.data)) {
      vec4 below = view.over != 0u ? load_colour(view, at) : vec4(view.background, 0.0);
      if (CONVERTS && view.over != 0u) below = converted(view, below, below.w, true);
      precise vec4 dim = transmittance[p] * below;
      precise vec4 laid = vec4(colour[p], alpha) + dim;
      const bool whole = view.format == rgb_float || (view.over == 0u && view.background != vec3(0.0));
      if (CONVERTS) store_colour(view, at, converted(view, laid, whole ? 1.0 : laid.w, false));
      else store_colour(view, at, laid);
    }
    if (!is_null(view.alpha.data)) floats_of(view.alpha, at, 1u).at[0] = alpha;
    if (DEPTH) floats_of(view.depth, at, 1u).at[0] = alpha > 0.0 ? depth[p] / alpha : 0.0;
    if (PICKS) {
      if (!is_null(view.first_depth.data))
        floats_of(view.first_depth, at, 1u).at[0] = first[p] == NONE ? 0.0 : colours.at[first[p]].w;
      if (!is_null(view.median_depth.data))
        floats_of(view.median_depth, at, 1u).at[0] = median[p] == NONE ? 0.0 : colours.at[median[p]].w;
      if (!is_null(view.id.data)) words_of(view.id, at, 1u).at[0] = largest[p] == NONE ? NONE : gaussians.at[largest[p]];
      if (!is_null(view.median_id.data))
        words_of(view.median_id, at, 1u).at[0] = median[p] == NONE ? NONE : gaussians.at[median[p]];
    }
  }
}
