// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"
#include "attributes.glsl"
#include "pixels.glsl"
#include "alpha.glsl"

// Blends the splats of a warp block of 8x8 pixels, which a subgroup shares, or several that have PARTS of it: each lane
// has every SUBGROUP-th pixel of a part. It tests a splat a lane against the block, then blends the splats that touch it,
// one after the other.

// What the view asks for beside colour and alpha.
layout(constant_id = 5) const bool DEPTH = false;
layout(constant_id = 6) const bool PICKS = false;
layout(constant_id = 7) const bool OCCLUDER = false;
layout(constant_id = 8) const bool CONVERTS = false;
// Attributes of a pass; and whether the pass draws the other planes too.
layout(constant_id = 9) const uint ATTRIBUTES = 0u;
layout(constant_id = 10) const bool IS_BASE = true;
// Whether depths are those along the ray: the first attributes of a splat.
layout(constant_id = 11) const bool ALONG_RAY = false;

// Whether the weights are added to `contributions` and nothing is drawn, and whether colours tell who is hidden.
layout(constant_id = 12) const bool CONTRIBUTES = false;
layout(constant_id = 13) const bool HAS_COLOURS = true;

layout(constant_id = 14) const uint PARTS = 1u;

layout(push_constant, scalar) uniform Push {
  RasterViews views;  // this view alone
  Shapes shapes;
  Colours colours;
  Uints gaussians, ids, ranges;
  AttributeLists attributes_of;  // this view alone
  Floats attributes;
  Floats ray_depths;    // the first of the frame's attributes
  Uints contributions;  // 64-bit sums of Gaussians, by halves
  uint ray_depth_stride;
};

const uint SIDE = 8u, EACH = SIDE * SIDE / (SUBGROUP * PARTS);
const uint NONE = 0xffffffffu, SUMS = ATTRIBUTES == 0u ? 1u : ATTRIBUTES;

// Place of pixel `p` of this lane in the block.
uvec2 place_of(uint p) {
  const uint n = (gl_WorkGroupID.z * EACH + p) * SUBGROUP + gl_SubgroupInvocationID;
  return uvec2(n % SIDE, n / SIDE);
}

// The depth of splat `id` along the ray of a pixel, `place` from the middle of the image.
float ray_depth_at(uint id, vec2 place) {
  const uint at = id * ray_depth_stride;
  precise float x = ray_depths.at[at + 1u] * place.x;
  precise float y = ray_depths.at[at + 2u] * place.y;
  precise float slopes = x + y;
  precise float depth = ray_depths.at[at] + slopes;
  return depth;
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

float picked_depth(uint id, vec2 place) {
  if (id == NONE) return 0.0;
  return ALONG_RAY ? ray_depth_at(id, place) : colours.at[id].w;
}

// Adds to the sum of Gaussian `g` what the lanes have, in halves of 16 bits. All lanes call it.
void contribute(uint g, uint low_bits, uint high_bits) {
  const uint low = subgroupAdd(low_bits), high = subgroupAdd(high_bits);
  if (gl_SubgroupInvocationID != 0u || (low | high) == 0u) return;
  uint carry;
  const uint parts = uaddCarry(high << 16, low, carry);
  const uint before = atomicAdd(contributions.at[2u * g], parts);
  if (before + parts < before) ++carry;
  if ((high >> 16) + carry != 0u) atomicAdd(contributions.at[2u * g + 1u], (high >> 16) + carry);
}

void main() {
  const RasterView view = views.at[0];
  const TileGrid grid = view.grid;
  const uvec2 block = gl_WorkGroupID.xy * SIDE;
  const ivec2 first_pixel = ivec2(grid.first_column, grid.first_row) * grid.side + ivec2(block);
  const vec2 first_centre = vec2(first_pixel) + 0.5;
  const vec2 first_place = first_centre - view.middle;
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
    for (uint k = 0u; k < SUMS; ++k) sums[p * SUMS + k] = 0.0;
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
    const vec4 of_mine = HAS_COLOURS ? colours.at[mine] : vec4(1.0);
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
      const uint id = CONTRIBUTES || PICKS || ALONG_RAY || ATTRIBUTES != 0u ? subgroupShuffle(mine, lane) : NONE;
      Split split;
      if (EXPONENT == float_split) split = split_of(s, raster_centre);
      all_stopped = true;
      uint low_bits = 0u, high_bits = 0u;
      for (uint p = 0u; p < EACH; ++p) {
        const vec2 at = first_centre + vec2(place_of(p));
        float alpha = alpha_of(s, exponent_of(s, split, raster_centre, at), view);
        // Depths along the ray do not ascend in a list: the pixel skips a hidden splat.
        if (ALONG_RAY && OCCLUDER && alpha != 0.0 &&
            ray_depth_at(id, first_place + vec2(place_of(p))) >= occluded_from[p])
          alpha = 0.0;
        if (!stopped[p] && alpha != 0.0) {
          const float next = dimmed(transmittance[p], alpha);
          if (next < view.stop_below || (OCCLUDER && !ALONG_RAY && rgb_depth.w >= occluded_from[p])) {
            stopped[p] = true;
          } else {
            precise float weight = alpha * transmittance[p];
            if (CONTRIBUTES) {
              const uint parts = uint(weight * 2147483648.0);
              low_bits += parts & 0xffffu;
              high_bits += parts >> 16;
            }
            precise vec3 more = weight * rgb_depth.rgb;
            precise vec3 sum = colour[p] + more;
            colour[p] = sum;
            if (DEPTH) depth[p] += weight * rgb_depth.w;
            for (uint k = 0u; k < ATTRIBUTES; ++k) sums[p * SUMS + k] += weight * attributes.at[id * ATTRIBUTES + k];
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
      if (CONTRIBUTES) contribute(gaussians.at[id], low_bits, high_bits);
    }
  }

  for (uint p = 0u; p < EACH; ++p) {
    const uvec2 at = block + place_of(p);
    if (at.x >= view.width || at.y >= view.height) continue;
    const vec2 place = first_place + vec2(place_of(p));
    precise float alpha = 1.0 - transmittance[p];
    for (uint k = 0u; k < ATTRIBUTES; ++k) {
      const Attribute to = attributes_of.at[0].each[k];
      const uint from = p * SUMS + k;
      const float sum = sums[from];
      if (to.of == of_ray_depth && to.channel == 0u && !is_null(view.depth.data)) {
        precise float slopes = sums[from + 1u] * place.x + sums[from + 2u] * place.y;
        floats_of(view.depth, at, 1u).at[0] = alpha > 0.0 ? (sum + slopes) / alpha : 0.0;
      }
      if (to.of == of_squared_ray_depth && to.channel == 0u) {  // as `sum_of_squares`
        precise float linear = sums[from + 1u] * place.x + sums[from + 2u] * place.y;
        precise float by_x = sums[from + 3u] * place.x + sums[from + 4u] * place.y;
        precise float by_y = sums[from + 5u] * place.y;
        precise float square = sum + (linear + (by_x * place.x + by_y * place.y));
        floats_of(view.squared_depth, at, 1u).at[0] = alpha > 0.0 ? square / alpha : 0.0;
      }
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
        floats_of(view.first_depth, at, 1u).at[0] = picked_depth(first[p], place);
      if (!is_null(view.median_depth.data))
        floats_of(view.median_depth, at, 1u).at[0] = picked_depth(median[p], place);
      if (!is_null(view.id.data)) words_of(view.id, at, 1u).at[0] = largest[p] == NONE ? NONE : gaussians.at[largest[p]];
      if (!is_null(view.median_id.data))
        words_of(view.median_id, at, 1u).at[0] = median[p] == NONE ? NONE : gaussians.at[median[p]];
    }
  }
}
