// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <swiftgs/cuda/warp.cuh>
#include <swiftgs/raster/raster.hpp>
#include <swiftgs/store_pixel.hpp>

namespace swiftgs::kernels {

/// What a frame wants beside colour and alpha. Kernels that know of neither are compiled apart.
inline bool wants_extras(const RasterJob& job) {
  return job.frame.depth.data || job.frame.occluder.data || job.counts;
}

/// exp2 of the device's special function unit: 2 units in the last place.
__device__ inline float exp2_approx(float x) {
  float result;
  asm("ex2.approx.ftz.f32 %0, %1;" : "=f"(result) : "f"(x));
  return result;
}

/// A pixel while splats are blended into it. When it stops, its transmittance moves to `last` and becomes zero, so that
/// whatever follows adds nothing, and `stop_below` becomes negative, so that it does not stop again.
struct Pixel {
  float red = 0, green = 0, blue = 0, depth = 0;
  float transmittance = 0, last = 1;
  float stop_below = -1;

  __device__ void start(float stop) { transmittance = 1, stop_below = stop; }
  __device__ bool live() const { return stop_below >= 0; }
  __device__ void stop() { stop_with(transmittance); }
  __device__ void stop_with(float left) { last = left, transmittance = 0, stop_below = -1; }

  __device__ void add(float weight, float r, float g, float b) {
    red = fmaf(weight, r, red), green = fmaf(weight, g, green), blue = fmaf(weight, b, blue);
  }

  /// What is left of 1, of which `alpha` was covered.
  __device__ static float dimmed(float transmittance, float alpha) {
    return fmaf(-alpha, transmittance, transmittance);
  }

  __device__ BlendedPixel blended() const {
    return {vec3(red, green, blue), live() ? transmittance : last, depth};
  }
};

/// Where a pixel lies, and what a frame asks of it beside colour.
struct PixelPlace {
  int x, y;
  bool inside;
  float occluder;  ///< camera-space z of what hides the splats behind it

  __device__ PixelPlace(const RasterJob& job, int x_, int y_, bool extras)
      : x(x_), y(y_), inside(x_ < job.frame.width && y_ < job.frame.height), occluder(INFINITY) {
    if (extras && inside && job.frame.occluder.data) occluder = job.frame.occluder.row(std::size_t(y))[x];
  }
};

/// Counts of one thread.
struct ThreadCounts {
  std::uint32_t pairs = 0, stopped = 0;
};

/// Blends one splat into a pixel, front to back; `alpha` is 0 where the pixel skips it.
template <bool extras>
__device__ void blend(Pixel& pixel, float alpha, const float4& colour, float occluder, ThreadCounts& counts) {
  if (!(alpha > 0)) return;
  const float left = Pixel::dimmed(pixel.transmittance, alpha);
  if (left < pixel.stop_below || (extras && pixel.live() && colour.w >= occluder)) {
    if (extras) ++counts.stopped;
    pixel.stop();
    return;
  }
  const float weight = alpha * pixel.transmittance;
  pixel.add(weight, colour.x, colour.y, colour.z);
  if (extras) pixel.depth = fmaf(weight, colour.w, pixel.depth), counts.pairs += pixel.live();
  pixel.transmittance = left;
}

/// Adds what a warp counted to its tile.
__device__ inline void add_counts(TileCounts* counts, std::uint32_t tile, const ThreadCounts& mine,
                                  std::uint32_t instances, std::uint32_t pixels) {
  using Word = unsigned long long;
  const auto field = [&](std::uint64_t TileCounts::*member) {
    return reinterpret_cast<Word*>(&(counts[tile].*member));
  };
  const std::uint32_t pairs = warp_sum(mine.pairs), stopped = warp_sum(mine.stopped);
  if (lane_index() != 0) return;
  atomicMax(field(&TileCounts::instances_visited), Word(instances));
  atomicAdd(field(&TileCounts::rows_visited), Word(pixels / tile_side));
  atomicAdd(field(&TileCounts::contributing_pairs), Word(pairs));
  atomicAdd(field(&TileCounts::pixels_stopped), Word(stopped));
}

/// 32 bytes in two loads.
__device__ inline SplatShape load_shape(const RasterJob& job, std::uint32_t id) {
  const float4* words = reinterpret_cast<const float4*>(job.splats.shapes.data + id);
  const float4 a = words[0], b = words[1];
  SplatShape shape;
  shape.mean = vec2(a.x, a.y), shape.l0 = a.z, shape.l1 = a.w;
  shape.l2 = b.x, shape.opacity = b.y, shape.reach = b.z, shape.half_width = b.w;
  return shape;
}

/// RGB and depth in one load.
__device__ inline float4 load_colour(const RasterJob& job, std::uint32_t id) {
  return *reinterpret_cast<const float4*>(job.splats.colours.data + id);
}

/// Whether the ellipse s <= reach meets the box of pixel centres that begins at `first` and is `side` - 1 wide and high.
///
/// What does not pass is not drawn, whatever lists it: lossless bounds are wider than this, so frames do not depend on
/// them. s is convex: its least value lies at the mean, or on the edge that is nearest at the mean's height.
__device__ inline bool box_touched(const SplatShape& s, vec2 first, float side) {
  const float left = first.x - s.mean.x, right = left + (side - 1);
  const float top = first.y - s.mean.y, bottom = top + (side - 1);
  const float nearest_y = fminf(fmaxf(0, top), bottom);
  const float u_left = fmaf(s.l0, left, s.l1 * nearest_y), u_right = fmaf(s.l0, right, s.l1 * nearest_y);
  const float edge = u_left > 0 ? left : right;
  const float along = __fdividef(-s.l0 * s.l1 * edge, fmaf(s.l1, s.l1, s.l2 * s.l2));
  const bool across = u_left <= 0 && u_right >= 0;
  const float y = across ? nearest_y : fminf(fmaxf(along, top), bottom);
  const float u = across ? 0.0f : fmaf(s.l0, edge, s.l1 * y), v = s.l2 * y;
  // Pixels round differently from this: what is that close to the edge is left to them.
  return fmaf(u, u, v * v) <= s.reach * 1.0001f;
}

}  // namespace swiftgs::kernels
