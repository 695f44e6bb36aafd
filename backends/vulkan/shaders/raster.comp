// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "raster.glsl"

// A subgroup tests a splat a lane against its block and keeps the ids of those that touch it. It blends as many as it has
// lanes at a time, in groups: the alphas of a group do not wait for each other, and pixels test once a group whether they
// stop.

const uint NONE = 0xffffffffu, SUMS = ATTRIBUTES == 0u ? 1u : ATTRIBUTES;

bool needs_ids() { return CONTRIBUTES || PICKS || ATTRIBUTES != 0u || ALONG_RAY; }

// The depth of splat `id` along the ray of a pixel, `place` from the middle of the image.
float ray_depth_at(uint id, vec2 place) {
  Floats row = Floats(element(uvec2(ray_depths), id, 4u * ray_depth_stride));
  precise float x = row.at[1] * place.x;
  precise float y = row.at[2] * place.y;
  precise float slopes = x + y;
  precise float depth = row.at[0] + slopes;
  return depth;
}

float picked_depth(uint id, vec2 place) {
  if (id == NONE) return 0.0;
  return ALONG_RAY ? ray_depth_at(id, place) : colours.at[id].w;
}

// Adds to the sum of Gaussian `g` what the lanes have, in halves of 16 bits. All lanes call it.
void contribute(uint g, uint low_bits, uint high_bits) {
  const uint low = subgroupAdd(low_bits), high = subgroupAdd(high_bits);
  if (gl_SubgroupInvocationID == 0u && (low | high) != 0u) add_halves(Uints(element(uvec2(contributions), g, 8u)), low, high);
}

// The id that this lane has of those from `from` on.
uint id_at(uint from, uint end) { return from + gl_SubgroupInvocationID < end ? ids.at[from + gl_SubgroupInvocationID] : 0u; }

void main() {
  // Only what blending needs: the rest of the view would take registers until it is needed at the end.
  const TileGrid grid = view.grid;
  const uvec2 size = uvec2(view.width, view.height);
  const float least = view.least, alpha_max = view.alpha_max, stop_below = view.stop_below;
  uvec2 block = gl_WorkGroupID.xy * SIDE;
  if (lists == long_lists && !long_block(block)) return;
  const ivec2 first_pixel = ivec2(grid.first_column, grid.first_row) * grid.side + ivec2(block);
  const vec2 first_centre = vec2(first_pixel) + 0.5;
  const vec2 first_place = first_centre - view.middle;
  const int log2_side = findMSB(grid.side);
  const uint tile = tile_number(grid, first_pixel.x >> log2_side, first_pixel.y >> log2_side);
  const uint begin = ranges.at[2u * tile], end = ranges.at[2u * tile + 1u];
  if (begin > end) return;  // as of `TileRange::undrawn`
  if (lists == other_lists && end - begin >= long_tiles.at[0]) return;

  Pixel all[EACH], pixels[EACH];  // behind the segments that are composited, and within one
  float sums_of_all[EACH * SUMS], sums[EACH * SUMS], weight_of_largest[EACH], occluded_from[EACH];
  uint first[EACH], median[EACH], largest[EACH];
  [[unroll]] for (uint p = 0u; p < EACH; ++p) {
    const uvec2 at = block + place_of(p);
    const bool inside = at.x < size.x && at.y < size.y;
    all[p] = pixel_of(0.0);
    pixels[p] = pixel_of(inside ? stop_below : -1.0);
    for (uint k = 0u; k < SUMS; ++k) sums_of_all[p * SUMS + k] = sums[p * SUMS + k] = 0.0;
    first[p] = median[p] = largest[p] = NONE;
    weight_of_largest[p] = 0.0;
    occluded_from[p] = OCCLUDER && inside ? occluder_at(view, at) : 0.0;
  }

  // Shapes are loaded a step ahead, and their ids two.
  const uint lane = gl_SubgroupInvocationID;
  uint next_id = id_at(begin, end), later_id = id_at(begin + SUBGROUP, end);
  ShapeWords next_shape;
  if (begin < end) next_shape = shapes.at[next_id];
  // Ids of `waiting` splats, one in each lane from the first on.
  uint waiting_id = 0u, waiting = 0u, blended = 0u;
  // lavapipe ends the loops of a thread after 65,535 rounds: leave some to the loops that store pixels.
  uint rounds = 0u;
  for (uint from = begin; (from < end || waiting != 0u) && (SUBGROUP >= 32u || rounds < 65000u); from += SUBGROUP) {
    ++rounds;
    uint following_id = 0u;  // of those behind as many as there are lanes
    if (from < end) {
      const uint id = next_id;
      const Shape shape = shape_of(next_shape);
      next_id = later_id;
      if (from + SUBGROUP < end) next_shape = shapes.at[next_id];
      later_id = id_at(from + 2u * SUBGROUP, end);
      const bool touches = from + lane < end && box_touched(shape, first_centre);
      const uvec4 touching = subgroupBallot(touches);
      if (lane < waiting) exchange(lane, waiting_id);
      if (touches) exchange(waiting + subgroupBallotExclusiveBitCount(touching), id);
      waiting += subgroupBallotBitCount(touching);
      share_in_subgroup();
      waiting_id = exchanged(lane);
      following_id = exchanged(lane + SUBGROUP);
      share_in_subgroup();
      if (waiting < SUBGROUP && from + SUBGROUP < end) continue;
    }

    const uint count = min(waiting, SUBGROUP), id = lane < count ? waiting_id : 0u;
    ShapeWords shape = ShapeWords(vec4(0.0), vec4(0.0));
    vec4 shade = vec4(0.0);
    if (lane < count) {
      shape = shapes.at[id];
      shade = HAS_COLOURS ? colours.at[id] : vec4(1.0);
    }
    enqueue(shape, shade, first_centre, alpha_max);

    for (uint of_group = 0u; of_group < count; of_group += GROUP) {
      Group group[EACH];
      evaluate(of_group, least, group);
      uint ids_of_group[GROUP];
      [[unroll]] for (uint k = 0u; k < GROUP; ++k) ids_of_group[k] = needs_ids() ? subgroupShuffle(id, of_group + k) : NONE;

      bool some_stop = false, occluded[EACH];
      [[unroll]] for (uint p = 0u; p < EACH; ++p) {
        occluded[p] = false;
        if (OCCLUDER) {
          [[unroll]] for (uint k = 0u; k < GROUP; ++k) {
            if (group[p].weight[k] == 0.0) continue;
            // Depths along the ray do not ascend in a list: the pixel skips a hidden splat.
            const bool hidden =
                (ALONG_RAY ? ray_depth_at(ids_of_group[k], first_place + vec2(place_of(p))) : shades[of_group + k].w) >=
                occluded_from[p];
            occluded[p] = occluded[p] || (hidden && !ALONG_RAY);
            if (hidden || occluded[p]) group[p].weight[k] = 0.0;
          }
        }
        some_stop = weigh(pixels[p], group[p], alpha_max) || some_stop;
      }
      if (some_stop) {
        [[unroll]] for (uint p = 0u; p < EACH; ++p) undo(pixels[p], group[p]);
      }
      if (OCCLUDER) {
        [[unroll]] for (uint p = 0u; p < EACH; ++p)
          if (occluded[p] && pixels[p].limit >= 0.0) {
            pixels[p].limit = -pixels[p].transmittance;
            pixels[p].transmittance = 0.0;
          }
      }

      [[unroll]] for (uint k = 0u; k < GROUP; ++k) {
        const vec4 shade = shades[of_group + k];
        const uint of_splat = ids_of_group[k];
        Floats row = Floats(element(uvec2(attributes), of_splat, 4u * ATTRIBUTES));
        uint low_bits = 0u, high_bits = 0u;
        [[unroll]] for (uint p = 0u; p < EACH; ++p) {
          add(pixels[p], group[p].weight[k], shade);
          for (uint a = 0u; a < ATTRIBUTES; ++a) sums[p * SUMS + a] += group[p].weight[k] * row.at[a];
          const float w = group[p].weight[k] * all[p].transmittance;
          if (PICKS && w > 0.0) {
            const float behind = group[p].left[k + 1u] * all[p].transmittance;
            if (w > weight_of_largest[p]) {
              largest[p] = of_splat;
              weight_of_largest[p] = w;
            }
            if (first[p] == NONE && behind < view.first_below) first[p] = of_splat;
            if (median[p] == NONE && behind < 0.5) median[p] = of_splat;
          }
          if (CONTRIBUTES) {
            const uint parts = uint(w * alpha_max * 2147483648.0);
            low_bits += parts & 0xffffu;
            high_bits += parts >> 16;
          }
        }
        if (CONTRIBUTES && of_group + k < count) contribute(gaussians.at[of_splat], low_bits, high_bits);
      }
    }
    rounds += SUBGROUP / GROUP + 1u;
    waiting -= count;
    waiting_id = following_id;
    blended += count;
    bool all_stopped = true;
    [[unroll]] for (uint p = 0u; p < EACH; ++p) all_stopped = all_stopped && pixels[p].limit < 0.0;
    if (subgroupAll(all_stopped)) break;
    if (blended % SEGMENT == 0u) {
      [[unroll]] for (uint p = 0u; p < EACH; ++p) {
        for (uint k = 0u; k < ATTRIBUTES; ++k) {
          sums_of_all[p * SUMS + k] += alpha_max * all[p].transmittance * sums[p * SUMS + k];
          sums[p * SUMS + k] = 0.0;
        }
        composite(all[p], pixels[p], alpha_max);
        pixels[p] = pixel_of(pixels[p].limit < 0.0 ? -1.0 : limit_of(stop_below, all[p].transmittance));
      }
    }
    share_in_subgroup();
  }

  // Copies, because an array that a loop indexes leaves the registers, and would do so above too.
  Pixel shown[EACH];
  uvec3 picked[EACH];
  [[unroll]] for (uint p = 0u; p < EACH; ++p) {
    for (uint k = 0u; k < ATTRIBUTES; ++k) sums_of_all[p * SUMS + k] += alpha_max * all[p].transmittance * sums[p * SUMS + k];
    composite(all[p], pixels[p], alpha_max);
    shown[p] = all[p];
    picked[p] = uvec3(first[p], median[p], largest[p]);
  }
  // Mesa unrolls a loop over an array whose rounds it can count, and software then compiles the store EACH times. Hide
  // their number from it.
  const uint pixels_of_lane = SUBGROUP < 32u && EACH > 1u ? min(EACH, size.x * EACH) : EACH;
  for (uint p = 0u; p < pixels_of_lane; ++p) {
    const uvec2 at = block + place_of(p);
    if (at.x >= size.x || at.y >= size.y) continue;
    const vec2 place = first_place + vec2(place_of(p));
    precise float alpha = 1.0 - left_by(shown[p]);
    for (uint k = 0u; k < ATTRIBUTES; ++k) {
      const Attribute to = attributes_of.at[0].each[k];
      const uint from = p * SUMS + k;
      const float sum = sums_of_all[from];
      if (to.of == of_ray_depth && to.channel == 0u && !is_null(view.depth.data)) {
        precise float slopes = sums_of_all[from + 1u] * place.x + sums_of_all[from + 2u] * place.y;
        floats_of(view.depth, at, 1u).at[0] = alpha > 0.0 ? (sum + slopes) / alpha : 0.0;
      }
      if (to.of == of_squared_ray_depth && to.channel == 0u) {  // as `sum_of_squares`
        precise float linear = sums_of_all[from + 1u] * place.x + sums_of_all[from + 2u] * place.y;
        precise float by_x = sums_of_all[from + 3u] * place.x + sums_of_all[from + 4u] * place.y;
        precise float by_y = sums_of_all[from + 5u] * place.y;
        precise float square = sum + (linear + (by_x * place.x + by_y * place.y));
        floats_of(view.squared_depth, at, 1u).at[0] = alpha > 0.0 ? square / alpha : 0.0;
      }
      if (to.of == of_normal) floats_of(view.normal, at, 3u).at[to.channel] = sum;
      if (to.of == of_squared_depth) floats_of(view.squared_depth, at, 1u).at[0] = alpha > 0.0 ? sum / alpha : 0.0;
      if (to.of == of_feature) floats_of(view.features, at, view.feature_channels).at[to.channel] = sum;
    }
    if (!IS_BASE) continue;
    store(view, at, shown[p]);
    if (PICKS) {
      const uint first_id = picked[p].x, median_id = picked[p].y, largest_id = picked[p].z;
      if (!is_null(view.first_depth.data))
        floats_of(view.first_depth, at, 1u).at[0] = picked_depth(first_id, place);
      if (!is_null(view.median_depth.data))
        floats_of(view.median_depth, at, 1u).at[0] = picked_depth(median_id, place);
      if (!is_null(view.id.data)) words_of(view.id, at, 1u).at[0] = largest_id == NONE ? NONE : gaussians.at[largest_id];
      if (!is_null(view.median_id.data))
        words_of(view.median_id, at, 1u).at[0] = median_id == NONE ? NONE : gaussians.at[median_id];
    }
  }
}
