// SPDX-License-Identifier: Apache-2.0

// What rasterizing kernels share: which splats touch a block of 8x8 pixels, and how its pixels blend them. A subgroup has
// a block, or several subgroups have PARTS of it; each lane has pixels that are next to each other.

#include "frame.glsl"
#include "attributes.glsl"
#include "pixels.glsl"
#include "alpha.glsl"

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

// Whether the weights are added to `contributions` and nothing is drawn, and whether colours tell who has none.
layout(constant_id = 12) const bool CONTRIBUTES = false;
layout(constant_id = 13) const bool HAS_COLOURS = true;

layout(constant_id = 14) const uint PARTS = 1u;

layout(set = 1, binding = 0, scalar) uniform Constants { RasterView view; };
layout(push_constant, scalar) uniform Push {
  Shapes shapes;
  Colours colours;
  Uints gaussians, ids, ranges;
  AttributeLists attributes_of;  // this view alone
  Floats attributes;
  Floats ray_depths;    // the first of the frame's attributes
  Uints contributions;  // 64-bit sums of Gaussians, by halves
  Uints long_tiles;  // the length from which on lists are long, tiles of these
  uint ray_depth_stride;
  uint lists;  // which are drawn
};
const uint all_lists = 0u, long_lists = 1u, other_lists = 2u;

const uint SIDE = 8u, EACH = SIDE * SIDE / (SUBGROUP * PARTS);
// Splats that are blended together: two where a lane has many pixels; one where several subgroups share a block, because
// software takes 1.6 times as long to compile four.
const uint GROUP = PARTS > 1u ? 1u : EACH > 2u ? 2u : 4u, GROUP_END = GROUP + 1u;

// Place of pixel `p` of this lane in the block.
uvec2 place_of(uint p) {
  const uint first = (gl_WorkGroupID.z * SUBGROUP + gl_SubgroupInvocationID) * EACH;
  return uvec2(first % SIDE + p % SIDE, first / SIDE + p / SIDE);
}

// The block of this workgroup in a launch over the tiles of long lists. None where it is of another view or outside.
bool long_block(out uvec2 block) {
  const uint side = uint(view.grid.side), blocks = side / SIDE, of_tile = gl_WorkGroupID.x % (blocks * blocks);
  const uint tile = long_tiles.at[1u + gl_WorkGroupID.x / (blocks * blocks)], of_view = tile - view.grid.first;
  block = uvec2(of_view % view.grid.stride, of_view / view.grid.stride) * side + uvec2(of_tile % blocks, of_tile / blocks) * SIDE;
  return tile >= view.grid.first && block.x < view.width && block.y < view.height;
}

// Splats that touch the block are blended in segments. Each is blended as if it were alone and composited behind those in
// front of it, so that many subgroups may blend the segments of a list, with the bits of one that blends them all. All
// conservative bounds list the same splats that touch, so they have the same segments.
const uint SEGMENT = 128u;

// As `box_touched` of `Cuda`: whether the ellipse s <= cutoff meets the box of the block's pixel centres. Kernels that
// blend the segments of one list must agree, so no compiler may fuse operations of its own choice.
bool box_touched(Shape s, vec2 first) {
  const float left = right_of_mean(s, first.x), top = below_mean(s, first.y);
  precise float right = left + float(SIDE - 1u);
  precise float bottom = top + float(SIDE - 1u);
  const float nearest_y = min(max(0.0, top), bottom);
  precise float tilt = s.l1 * nearest_y;
  precise float u_left = fma(s.l0, left, tilt);
  precise float u_right = fma(s.l0, right, tilt);
  precise float on_edge = s.l0 * (u_left > 0.0 ? left : right);
  precise float l2_squared = s.l2 * s.l2;
  precise float above = -s.l1 * on_edge;
  // Two roots in place of a division, for which drivers call a function.
  const float inverse_root = inversesqrt(fma(s.l1, s.l1, l2_squared));
  precise float along_edge = above * inverse_root * inverse_root;
  const bool across = u_left <= 0.0 && u_right >= 0.0;
  const float y = across ? nearest_y : min(max(along_edge, top), bottom);
  precise float u = fma(s.l1, y, on_edge);
  precise float v = s.l2 * y;
  precise float v_squared = v * v;
  precise float nearest = across ? v_squared : fma(u, u, v_squared);
  precise float most = s.cutoff * 1.0001;
  return nearest <= most;
}

// A pixel of a segment. Colour and depth are in units of alpha_max. When it stops it loses its transmittance, so that
// later splats add nothing, and `limit` holds what was left, negated.
struct Pixel {
  float transmittance, limit, depth;
  vec3 colour;
};
Pixel pixel_of(float limit) { return Pixel(limit < 0.0 ? 0.0 : 1.0, limit, 0.0, vec3(0.0)); }
float left_by(Pixel pixel) { return pixel.limit < 0.0 ? -pixel.limit : pixel.transmittance; }

// The limit within a segment that has this transmittance in front of it. Only a splat stops a pixel.
float limit_of(float stop_below, float before) { return before > 0.0 ? min(stop_below / before, 1.0) : 0.0; }

// A group of splats as a pixel sees them.
struct Group {
  float weight[GROUP];   // alphas at first
  float left[GROUP_END]; // the transmittances in front of each, and behind the last
};

// Splats that a subgroup blends next, a lane each. Shared memory bounds how many subgroups a device runs at once: with a
// quarter more, rasterizing takes a tenth longer on an H200.
shared vec4 exponents[THREADS], shades[THREADS];
shared uvec2 rests[THREADS];  // bits of the first two
shared float cutoffs[THREADS], last_terms[HAS_LAST_TERM ? THREADS : 1u];

// Numbers that the lanes of a subgroup exchange while nothing is queued: twice as many as it has lanes.
void exchange(uint k, uint number) {
  rests[gl_SubgroupID * SUBGROUP + k % SUBGROUP][k / SUBGROUP] = number;
}
uint exchanged(uint k) { return rests[gl_SubgroupID * SUBGROUP + k % SUBGROUP][k / SUBGROUP]; }

// Puts a splat where its subgroup blends it. A colourless one shows nothing.
void enqueue(ShapeWords shape, vec4 shade, vec2 first_centre, float alpha_max) {
  Terms terms = no_terms();
  if (shade.w > 0.0) terms = terms_of(shape_of(shape), first_centre, alpha_max);
  share_in_subgroup();
  exponents[thread()] = terms.exponent;
  rests[thread()] = floatBitsToUint(terms.rest.xy);
  cutoffs[thread()] = terms.rest.z;
  if (HAS_LAST_TERM) last_terms[thread()] = terms.rest.w;
  shades[thread()] = shade;
  share_in_subgroup();
}

// Finds the alphas of the group in slots from `slot` on.
void evaluate(uint slot, float least, out Group group[EACH]) {
  [[unroll]] for (uint k = 0u; k < GROUP; ++k) {
    const float last_term = HAS_LAST_TERM ? last_terms[slot + k] : 0.0;
    const Terms terms = Terms(exponents[slot + k], vec4(uintBitsToFloat(rests[slot + k]), cutoffs[slot + k], last_term));
    [[unroll]] for (uint p = 0u; p < EACH; ++p)
      group[p].weight[k] = alpha_of(terms, vec2(place_of(p)), least);
#ifdef OWN_RASTERIZER
    if (!(shades[slot + k].w > 0.0))
      [[unroll]] for (uint p = 0u; p < EACH; ++p) group[p].weight[k] = 0.0;  // a slot without a splat
#endif
  }
}

// Finds the weights of a group from its alphas, and dims the pixel. Returns whether it stops.
bool weigh(inout Pixel pixel, inout Group g, float alpha_max) {
  g.left[0] = pixel.transmittance;
  [[unroll]] for (uint k = 0u; k < GROUP; ++k) {
    const float alpha = g.weight[k];
    g.weight[k] = alpha * g.left[k];
    g.left[k + 1u] = dimmed(g.left[k], alpha, g.weight[k], alpha_max);
  }
  pixel.transmittance = g.left[GROUP];
  return g.left[GROUP] < pixel.limit;
}

// If the pixel stops, undoes what the splat that stops it and those behind it weigh.
void undo(inout Pixel pixel, inout Group g) {
  if (!(g.left[GROUP] < pixel.limit)) return;
  float last = g.left[0];
  [[unroll]] for (uint k = 0u; k < GROUP; ++k) {
    if (g.left[k + 1u] < pixel.limit) g.weight[k] = 0.0;
    else last = g.left[k + 1u];
  }
  pixel.transmittance = 0.0;
  pixel.limit = -last;
}

void add(inout Pixel pixel, float weight, vec4 shade) {
  pixel.colour = fma(vec3(weight), shade.rgb, pixel.colour);
  if (DEPTH) pixel.depth = fma(weight, shade.w, pixel.depth);
}

// Composites `segment` behind a pixel.
void composite(inout Pixel all, Pixel segment, float alpha_max) {
  const float before = alpha_max * all.transmittance;
  all.colour = fma(vec3(before), segment.colour, all.colour);
  if (DEPTH) all.depth = fma(before, segment.depth, all.depth);
  all.transmittance *= left_by(segment);
}

// Stores what a pixel of a view's colour, alpha and mean depth shows.
void store(RasterView view, uvec2 at, Pixel pixel) {
  const float left = left_by(pixel);
  precise float alpha = 1.0 - left;
  if (!is_null(view.colour.data)) {
    vec4 below = view.over != 0u ? load_colour(view, at) : vec4(view.background, 0.0);
    if (CONVERTS && view.over != 0u) below = converted(view, below, below.w, true);
    precise vec4 dim = left * below;
    precise vec4 laid = vec4(pixel.colour, alpha) + dim;
    const bool whole = view.format == rgb_float || (view.over == 0u && view.background != vec3(0.0));
    if (CONVERTS) store_colour(view, at, converted(view, laid, whole ? 1.0 : laid.w, false));
    else store_colour(view, at, laid);
  }
  if (!is_null(view.alpha.data)) floats_of(view.alpha, at, 1u).at[0] = alpha;
  if (DEPTH) floats_of(view.depth, at, 1u).at[0] = alpha > 0.0 ? pixel.depth / alpha : 0.0;
}
