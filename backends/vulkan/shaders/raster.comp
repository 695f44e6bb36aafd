// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"
#include "attributes.glsl"
#include "pixels.glsl"
#include "alpha.glsl"

// Blends the splats of a warp block of 8x8 pixels, which a subgroup shares, or several that have PARTS of it. A subgroup
// tests a splat a lane against the block and queues those that touch it. It blends as many as it has lanes at a time, in
// groups: the alphas of a group do not wait for each other, and pixels test once a group whether they stop.

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
  Uints long_tiles;
  uint ray_depth_stride;
  uint lists;      // which are drawn
  uint long_list;  // intersections of a list that is long
};
const uint all_lists = 0u, long_lists = 1u, other_lists = 2u;

const uint SIDE = 8u, EACH = SIDE * SIDE / (SUBGROUP * PARTS);
// Splats that are blended together: fewer where a lane has many pixels, or software would compile for a minute.
const uint GROUP = EACH > 4u ? 1u : EACH > 2u ? 2u : 4u;
const uint NONE = 0xffffffffu, SUMS = ATTRIBUTES == 0u ? 1u : ATTRIBUTES;

// Two halves: one is filled while the other is blended.
const uint QUEUE = 2u * SUBGROUP;
shared vec4 exponents[QUEUE], rests[QUEUE], shades[QUEUE];
shared uint queued_ids[QUEUE];

// Pixels of a lane are next to each other. Place of pixel `p` of this lane in the block.
uvec2 place_of(uint p) {
  const uint first = (gl_WorkGroupID.z * SUBGROUP + gl_SubgroupInvocationID) * EACH;
  return uvec2(first % SIDE + p % SIDE, first / SIDE + p / SIDE);
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

// The id that this lane has of those from `from` on.
uint id_at(uint from, uint end) { return from + gl_SubgroupInvocationID < end ? ids.at[from + gl_SubgroupInvocationID] : 0u; }

void main() {
  const RasterView view = views.at[0];
  const TileGrid grid = view.grid;
  uvec2 block = gl_WorkGroupID.xy * SIDE;
  if (lists == long_lists) {
    const uint side = uint(grid.side), blocks = side / SIDE, of_tile = gl_WorkGroupID.x % (blocks * blocks);
    const uint tile = long_tiles.at[gl_WorkGroupID.x / (blocks * blocks)], of_view = tile - grid.first;
    block = uvec2(of_view % grid.stride, of_view / grid.stride) * side + uvec2(of_tile % blocks, of_tile / blocks) * SIDE;
    if (tile < grid.first || block.x >= view.width || block.y >= view.height) return;  // of another view, or outside
  }
  const ivec2 first_pixel = ivec2(grid.first_column, grid.first_row) * grid.side + ivec2(block);
  const vec2 first_centre = vec2(first_pixel) + 0.5;
  const vec2 first_place = first_centre - view.middle;
  const uint tile = tile_number(grid, first_pixel.x / grid.side, first_pixel.y / grid.side);
  const uint begin = ranges.at[2u * tile], end = ranges.at[2u * tile + 1u];
  if (begin > end) return;  // as of `TileRange::undrawn`
  if (lists == other_lists && end - begin >= long_list) return;

  // A pixel that stopped has no transmittance, so that later splats add nothing. Its limit holds what was left, negated.
  float transmittance[EACH], limit[EACH], depth[EACH], weight_of_largest[EACH], occluded_from[EACH];
  vec3 colour[EACH];
  float sums[EACH * SUMS];
  uint first[EACH], median[EACH], largest[EACH];
  [[unroll]] for (uint p = 0u; p < EACH; ++p) {
    const uvec2 at = block + place_of(p);
    const bool inside = at.x < view.width && at.y < view.height;
    transmittance[p] = inside ? 1.0 : 0.0;
    limit[p] = inside ? view.stop_below : -1.0;
    colour[p] = vec3(0.0);
    for (uint k = 0u; k < SUMS; ++k) sums[p * SUMS + k] = 0.0;
    depth[p] = 0.0;
    first[p] = median[p] = largest[p] = NONE;
    weight_of_largest[p] = 0.0;
    occluded_from[p] = OCCLUDER && inside ? occluder_at(view, at) : 0.0;
  }

  // Shapes are loaded a step ahead, and their ids two.
  const uint lane = gl_SubgroupInvocationID;
  uint next_id = id_at(begin, end), later_id = id_at(begin + SUBGROUP, end);
  ShapeWords next_shape;
  if (begin < end) next_shape = shapes.at[next_id];
  uint waiting = 0u, front = 0u;
  for (uint from = begin; from < end || waiting != 0u; from += SUBGROUP) {
    if (from < end) {
      const uint id = next_id;
      const Shape shape = shape_of(next_shape);
      next_id = later_id;
      if (from + SUBGROUP < end) next_shape = shapes.at[next_id];
      later_id = id_at(from + 2u * SUBGROUP, end);
      const bool touches = from + lane < end && box_touched(shape, first_centre);
      const uvec4 touching = subgroupBallot(touches);
      if (touches) {
        const uint slot = (front + waiting + subgroupBallotExclusiveBitCount(touching)) % QUEUE;
        const Terms terms = terms_of(shape, first_centre);
        exponents[slot] = terms.exponent;
        rests[slot] = terms.rest;
        queued_ids[slot] = id;
      }
      waiting += subgroupBallotBitCount(touching);
      if (waiting < SUBGROUP && from + SUBGROUP < end) continue;
    }

    const uint count = min(waiting, SUBGROUP);
    subgroupBarrier();
    {
      const uint slot = front + lane;
      vec4 shade = vec4(0.0);
      if (lane < count) shade = HAS_COLOURS ? colours.at[queued_ids[slot]] : vec4(1.0);
      shades[slot] = shade;
      // Neither a hidden splat nor what fills the last group is shown.
      if (!(shade.w > 0.0)) rests[slot] = vec4(0.0, 0.0, -1.0, 0.0);
    }
    subgroupBarrier();

    for (uint of_group = front; of_group < front + count; of_group += GROUP) {
      float weight[EACH * GROUP];  // alphas at first
      [[unroll]] for (uint k = 0u; k < GROUP; ++k) {
        const Terms terms = Terms(exponents[of_group + k], rests[of_group + k]);
        [[unroll]] for (uint p = 0u; p < EACH; ++p)
          weight[p * GROUP + k] = alpha_of(terms, vec2(place_of(p)), view.alpha_min, view.alpha_max);
      }

      float left[EACH * (GROUP + 1u)];  // the transmittances in front of each splat, and behind the last
      bool some_stop = false, occluded[EACH];
      [[unroll]] for (uint p = 0u; p < EACH; ++p) {
        const uint row = p * (GROUP + 1u);
        occluded[p] = false;
        left[row] = transmittance[p];
        [[unroll]] for (uint k = 0u; k < GROUP; ++k) {
          float alpha = weight[p * GROUP + k];
          if (OCCLUDER) {
            // Depths along the ray do not ascend in a list: the pixel skips a hidden splat.
            if (ALONG_RAY) {
              if (alpha != 0.0 &&
                  ray_depth_at(queued_ids[of_group + k], first_place + vec2(place_of(p))) >= occluded_from[p])
                alpha = 0.0;
            } else {
              occluded[p] = occluded[p] || (alpha != 0.0 && shades[of_group + k].w >= occluded_from[p]);
              if (occluded[p]) alpha = 0.0;
            }
          }
          weight[p * GROUP + k] = alpha * left[row + k];
          left[row + k + 1u] = dimmed(left[row + k], alpha, weight[p * GROUP + k]);
        }
        transmittance[p] = left[row + GROUP];
        some_stop = some_stop || left[row + GROUP] < limit[p];
      }
      if (some_stop) {
        [[unroll]] for (uint p = 0u; p < EACH; ++p) {
          const uint row = p * (GROUP + 1u);
          if (!(left[row + GROUP] < limit[p])) continue;
          // Undo from the splat on that stops the pixel.
          float last = left[row];
          [[unroll]] for (uint k = 0u; k < GROUP; ++k) {
            if (left[row + k + 1u] < limit[p]) weight[p * GROUP + k] = 0.0;
            else last = left[row + k + 1u];
          }
          transmittance[p] = 0.0;
          limit[p] = -last;
        }
      }
      if (OCCLUDER) {
        [[unroll]] for (uint p = 0u; p < EACH; ++p)
          if (occluded[p] && limit[p] >= 0.0) {
            limit[p] = -transmittance[p];
            transmittance[p] = 0.0;
          }
      }

      [[unroll]] for (uint k = 0u; k < GROUP; ++k) {
        const vec4 shade = shades[of_group + k];
        const uint id = CONTRIBUTES || PICKS || ATTRIBUTES != 0u ? queued_ids[of_group + k] : NONE;
        uint low_bits = 0u, high_bits = 0u;
        [[unroll]] for (uint p = 0u; p < EACH; ++p) {
          const float w = weight[p * GROUP + k];
          colour[p] = fma(vec3(w), shade.rgb, colour[p]);
          if (DEPTH) depth[p] = fma(w, shade.w, depth[p]);
          for (uint a = 0u; a < ATTRIBUTES; ++a) sums[p * SUMS + a] += w * attributes.at[id * ATTRIBUTES + a];
          if (PICKS && w > 0.0) {
            const float behind = left[p * (GROUP + 1u) + k + 1u];
            if (w > weight_of_largest[p]) {
              largest[p] = id;
              weight_of_largest[p] = w;
            }
            if (first[p] == NONE && behind < view.first_below) first[p] = id;
            if (median[p] == NONE && behind < 0.5) median[p] = id;
          }
          if (CONTRIBUTES) {
            const uint parts = uint(w * 2147483648.0);
            low_bits += parts & 0xffffu;
            high_bits += parts >> 16;
          }
        }
        if (CONTRIBUTES && of_group + k < front + count) contribute(gaussians.at[id], low_bits, high_bits);
      }
    }
    waiting -= count;
    front ^= SUBGROUP;
    bool all_stopped = true;
    [[unroll]] for (uint p = 0u; p < EACH; ++p) all_stopped = all_stopped && limit[p] < 0.0;
    if (subgroupAll(all_stopped)) break;
    subgroupBarrier();
  }

  for (uint p = 0u; p < EACH; ++p) {
    const uvec2 at = block + place_of(p);
    if (at.x >= view.width || at.y >= view.height) continue;
    const vec2 place = first_place + vec2(place_of(p));
    const float left = limit[p] < 0.0 ? -limit[p] : transmittance[p];
    precise float alpha = 1.0 - left;
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
      precise vec4 dim = left * below;
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
