// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "raster.glsl"

// Blends a block of a tile with a long list by a workgroup, in rounds: all threads find the splats that touch it, each
// subgroup blends a segment of them, and segments are composited. A round has twice as many segments as the one before it,
// so that blocks whose pixels stop early cost little. A segment starts with too low a limit, so its pixels
// stop late. Once transmittances are known, blend again where a pixel stops.

const uint SUBGROUPS = THREADS / SUBGROUP, PIXELS = SIDE * SIDE;

// Ids of splats that touch: `found` from `front` on. Holds those of a round and of one step more, 1,024 each.
const uint RING = 2048u;
shared uint ring[RING];
uint front = 0u, found = 0u, visited;

// Colour and transmittance of pixels behind the segments that are composited, and of each segment of a round; the
// transmittance of a pixel that stopped is negative.
shared vec4 composited[PIXELS], segments[SUBGROUPS * PIXELS];
shared float depths[DEPTH ? PIXELS : 1u], segment_depths[DEPTH ? SUBGROUPS * PIXELS : 1u];

// Finds splats until there are `wanted`, or the list ends. All threads call it, and test some neighbours each.
const uint TESTS = 4u;
void find(uint wanted, uint end, vec2 first_centre) {
  while (found < wanted && visited < end) {
    const uint first = visited + TESTS * thread();
    uint of[TESTS], touching = 0u, total;
    bool touches[TESTS];
    [[unroll]] for (uint k = 0u; k < TESTS; ++k) of[k] = first + k < end ? ids.at[first + k] : 0u;
    [[unroll]] for (uint k = 0u; k < TESTS; ++k) {
      touches[k] = first + k < end && box_touched(shape_of(shapes.at[of[k]]), first_centre);
      if (touches[k]) ++touching;
    }
    uint place = front + found + sum_before(touching, total);
    [[unroll]] for (uint k = 0u; k < TESTS; ++k)
      if (touches[k]) ring[place++ % RING] = of[k];
    found += total;
    visited += TESTS * THREADS;
  }
  barrier();
}

// Of the view. The rest of it would take registers until it is needed at the end.
float least, alpha_max, stop_below;

// The k-th splat found: one that does not exist shows nothing.
struct Found {
  ShapeWords shape;
  vec4 shade;
};
Found found_at(uint k, bool exists) {
  Found splat = Found(ShapeWords(vec4(0.0), vec4(0.0)), vec4(0.0));
  if (exists) {
    const uint id = ring[(front + k) % RING];
    splat = Found(shapes.at[id], colours.at[id]);
  }
  return splat;
}

// Blends `count` splats from the `from`-th found on, by a subgroup, which loads them a step ahead.
void blend(uint from, uint count, vec2 first_centre, inout Pixel pixels[EACH]) {
  const uint lane = gl_SubgroupInvocationID, first = gl_SubgroupID * SUBGROUP;
  Found next = found_at(from + lane, lane < count);
  for (uint k = 0u; k < count; k += SUBGROUP) {
    const Found splat = next;
    next = found_at(from + k + SUBGROUP + lane, k + SUBGROUP + lane < count);
    enqueue(splat.shape, splat.shade, first_centre, alpha_max);
    for (uint of_group = first; of_group < first + min(count - k, SUBGROUP); of_group += GROUP) {
      Group group[EACH];
      evaluate(of_group, least, group);
      bool some_stop = false;
      [[unroll]] for (uint p = 0u; p < EACH; ++p) some_stop = weigh(pixels[p], group[p], alpha_max) || some_stop;
      if (some_stop) {
        [[unroll]] for (uint p = 0u; p < EACH; ++p) undo(pixels[p], group[p]);
      }
      [[unroll]] for (uint n = 0u; n < GROUP; ++n)
        [[unroll]] for (uint p = 0u; p < EACH; ++p) add(pixels[p], group[p].weight[n], shades[of_group + n]);
    }
    bool all_stopped = true;
    [[unroll]] for (uint p = 0u; p < EACH; ++p) all_stopped = all_stopped && pixels[p].limit < 0.0;
    if (subgroupAll(all_stopped)) break;
  }
}

// Number of this lane's pixel `p` in the block.
uint number_of_pixel(uint p) { return gl_SubgroupInvocationID * EACH + p; }

void store_segment(Pixel pixels[EACH]) {
  [[unroll]] for (uint p = 0u; p < EACH; ++p) {
    const uint at = gl_SubgroupID * PIXELS + number_of_pixel(p);
    // Pixels that had stopped before see nothing of the segment, which leaves them as they are.
    const bool stops = pixels[p].limit < 0.0 && composited[number_of_pixel(p)].w > 0.0;
    segments[at] = vec4(pixels[p].colour, stops ? -left_by(pixels[p]) : left_by(pixels[p]));
    if (DEPTH) segment_depths[at] = pixels[p].depth;
  }
}

// Whether a pixel with transmittance `before` in front of a segment stops in it.
bool stops_in(float left, float before) { return left < 0.0 || left < limit_of(stop_below, before); }

void main() {
  const TileGrid grid = view.grid;
  const uvec2 size = uvec2(view.width, view.height);
  least = view.least;
  alpha_max = view.alpha_max;
  stop_below = view.stop_below;
  uvec2 block;
  if (!long_block(block)) return;
  const ivec2 first_pixel = ivec2(grid.first_column, grid.first_row) * grid.side + ivec2(block);
  const vec2 first_centre = vec2(first_pixel) + 0.5;
  const int log2_side = findMSB(grid.side);
  const uint tile = tile_number(grid, first_pixel.x >> log2_side, first_pixel.y >> log2_side);
  const uint end = ranges.at[2u * tile + 1u];
  visited = ranges.at[2u * tile];

  for (uint i = thread(); i < PIXELS; i += THREADS) {
    const uvec2 at = block + uvec2(i % SIDE, i / SIDE);
    composited[i] = vec4(vec3(0.0), at.x < size.x && at.y < size.y ? 1.0 : -1.0);
    if (DEPTH) depths[i] = 0.0;
  }
  barrier();

  Pixel pixels[EACH];
  uint count = 0u;
  for (uint most = SEGMENT;; most = min(2u * most, SUBGROUPS * SEGMENT)) {
    bool some_live = false;
    [[unroll]] for (uint p = 0u; p < EACH; ++p) some_live = some_live || composited[number_of_pixel(p)].w > 0.0;
    if (!subgroupAny(some_live)) break;
    front = (front + count) % RING;
    found -= count;
    find(most, end, first_centre);
    count = min(found, most);
    if (count == 0u) break;

    const uint from = gl_SubgroupID * SEGMENT, own = min(count - min(from, count), SEGMENT);
    [[unroll]] for (uint p = 0u; p < EACH; ++p) {
      const float before = composited[number_of_pixel(p)].w;
      pixels[p] = pixel_of(before > 0.0 ? limit_of(stop_below, before) : -1.0);
    }
    blend(from, own, first_centre, pixels);
    store_segment(pixels);
    barrier();

    bool again = false;
    [[unroll]] for (uint p = 0u; p < EACH; ++p) {
      float before = composited[number_of_pixel(p)].w;
      bool live = before > 0.0;
      for (uint s = 0u; s < gl_SubgroupID; ++s) {
        const float left = segments[s * PIXELS + number_of_pixel(p)].w;
        live = live && !stops_in(left, before);
        before *= abs(left);
      }
      const float left = segments[gl_SubgroupID * PIXELS + number_of_pixel(p)].w;
      again = again || (live && gl_SubgroupID != 0u && stops_in(left, before));
      pixels[p] = pixel_of(live ? limit_of(stop_below, before) : -1.0);
    }
    barrier();
    if (subgroupAny(again)) {
      blend(from, own, first_centre, pixels);
      store_segment(pixels);
    }
    barrier();

    for (uint i = thread(); i < PIXELS; i += THREADS) {
      Pixel all = Pixel(composited[i].w, 0.0, DEPTH ? depths[i] : 0.0, composited[i].rgb);
      bool live = all.transmittance > 0.0;
      for (uint s = 0u; s < SUBGROUPS && live; ++s) {
        const vec4 segment = segments[s * PIXELS + i];
        const float depth = DEPTH ? segment_depths[s * PIXELS + i] : 0.0;
        composite(all, Pixel(abs(segment.w), 0.0, depth, segment.rgb), alpha_max);
        live = segment.w >= 0.0;
      }
      composited[i] = vec4(all.colour, live ? all.transmittance : -abs(all.transmittance));
      if (DEPTH) depths[i] = all.depth;
    }
    barrier();
  }

  for (uint i = thread(); i < PIXELS; i += THREADS) {
    const uvec2 at = block + uvec2(i % SIDE, i / SIDE);
    if (at.x < size.x && at.y < size.y)
      store(view, at, Pixel(abs(composited[i].w), 0.0, DEPTH ? depths[i] : 0.0, composited[i].rgb));
  }
}
