// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <cuda_pipeline_primitives.h>

#include "accumulators.cuh"

namespace swiftgs::kernels {

/// Whether all pixels of the warp stopped.
template <unsigned count>
__device__ bool all_stopped(const Pixel (&pixels)[count]) {
  bool stopped = true;
  for (const Pixel& pixel : pixels) stopped = stopped && !pixel.live();
  return __all_sync(whole_warp, stopped);
}

/// Depth of splats that show nothing and end a group: behind all others.
inline constexpr float padded_depth = 3.4028235e38f;

/// Keeps `variable` in memory: the traversal needs the registers.
template <class T>
__device__ T& in_memory(T& variable) {
  T* at = &variable;
  asm volatile("" : "+l"(at));
  return *at;
}

/// Exponents, colours and planes of queued splats.
template <class Exponent, class Planes>
struct Queue : TermsQueue<Exponent>, Planes::Queued {
  float4 colours[queue_size];  ///< RGB, depth

  /// Starts loading the colour and the planes of a splat.
  __device__ void fetch(const RasterJob& job, unsigned slot, std::uint32_t id) {
    __pipeline_memcpy_async(&colours[slot], job.colours.each.data + id, sizeof(float4));
    this->fetch_planes(job, slot, id);
  }
  /// Fills a slot with a splat that shows nothing.
  __device__ void clear(unsigned slot) {
    Exponent::clear(this->terms[slot], this->rests[slot]);
    colours[slot] = make_float4(0, 0, 0, padded_depth);
    this->clear_planes(slot);
  }
};

/// Blends queued splats into one or both pixels of a lane.
template <class Exponent, bool threshold, class Planes, unsigned pixel_count>
struct LaneBlender {
  BlendRules rules;
  bool sums_depth;
  float x, y, right;  ///< first pixel in the warp block; a single pixel lies `right` columns to its right
  Pixel pixels[pixel_count];
  float occluders[pixel_count];
  LaneRays<Planes::rays, pixel_count> rays;
  typename Planes::template Lane<pixel_count> planes;

  __device__ LaneBlender(const RasterJob& job, const View& view, float x_, float y_)
      : rules(view.rules),
        sums_depth(job.sums_depth(view)),
        x(x_),
        y(y_),
        right(0),
        occluders{},
        rays(job, view),
        planes(view) {}

  /// Blends `count` splats from `first` on: whole groups of `group_size` splats; one by one,
  /// any number.
  __device__ void blend_queued(const Queue<Exponent, Planes>& queue, unsigned first, unsigned count) {
    if constexpr (Planes::one_by_one) {
      for (unsigned k = first; k < first + count; ++k) {
        float alphas[pixel_count];
        evaluate(queue.terms[k], queue.rests[k], alphas);
        const bool along_ray = rays.depths;
#pragma unroll
        for (unsigned p = 0; p < pixel_count; ++p) {
          if (along_ray && alphas[p] > 0 && rays.hide(queue.ids[k], p)) alphas[p] = 0;
          const float before = pixels[p].transmittance;
          const float left = Pixel::dimmed_relative(before, alphas[p] * before, rules.alpha_max);
          blend<true>(pixels[p], alphas[p], left, queue.colours[k], along_ray ? INFINITY : occluders[p]);
          if (alphas[p] > 0 && pixels[p].live()) planes.offer(p, queue.ids[k], alphas[p] * before, before);
        }
      }
    } else if (Planes::depth && some_lie_behind(queue.colours[first + count - 1].w)) {
      blend_groups<true>(queue, first, count);
    } else {
      blend_groups<false>(queue, first, count);
    }
  }

  __device__ bool all_stopped() const { return kernels::all_stopped(pixels); }

 private:
  __device__ float nearest_occluder() const {
    return pixel_count == 2 ? fminf(occluders[0], occluders[pixel_count - 1]) : occluders[0];
  }
  /// Whether an occluder of the warp lies before this depth, or at it.
  __device__ bool some_lie_behind(float depth) const {
    return __any_sync(whole_warp, depth >= nearest_occluder());
  }

  /// `occluded`: some splats may lie at occluders or behind.
  template <bool occluded>
  __device__ void blend_groups(const Queue<Exponent, Planes>& queue, unsigned first, unsigned count) {
    // Advance pointers: an index would cost a multiplication each time.
    const float4 *terms = queue.terms + first, *colours = queue.colours + first;
    const typename Exponent::Rest* rests = queue.rests + first;
#pragma unroll 1
    for (unsigned k = 0; k < count; k += group_size) {
      blend_group<occluded>(terms, rests, colours, queue, first + k);
      terms += group_size, rests += group_size, colours += group_size;
    }
  }

  /// Alphas of the pixels for a splat, in units of alpha_max.
  __device__ void evaluate(const float4& terms, const typename Exponent::Rest& rest,
                           float (&alphas)[pixel_count]) const {
    float exponents[pixel_count];
    if constexpr (pixel_count == 1)
      exponents[0] = Exponent::evaluate_one(terms, rest, x, y, right);
    else
      Exponent::evaluate(terms, rest, x, y, exponents);
#pragma unroll
    for (unsigned p = 0; p < pixel_count; ++p) alphas[p] = relative_alpha<threshold>(exponents[p], rules);
  }

  template <bool occluded>
  __device__ void blend_group(const float4* terms, const typename Exponent::Rest* rests,
                              const float4* colours, const Queue<Exponent, Planes>& queue, unsigned first) {
    float alphas[pixel_count][group_size], weights[pixel_count][group_size];
#pragma unroll
    for (unsigned k = 0; k < group_size; ++k) {
      float of_splat[pixel_count];
      evaluate(terms[k], rests[k], of_splat);
#pragma unroll
      for (unsigned p = 0; p < pixel_count; ++p) alphas[p][k] = of_splat[p];
    }
    unsigned hidden = 0;
    if constexpr (occluded) hidden = hide(alphas, colours, queue, first);
    float left[pixel_count][group_size + 1];
    weigh_group(pixels, alphas, rules.alpha_max, weights, left);
    planes.offer_group(queue, first, weights, left);
    if constexpr (occluded) stop(hidden);

#pragma unroll
    for (unsigned k = 0; k < group_size; ++k) {
      const float4 colour = colours[k];
#pragma unroll
      for (unsigned p = 0; p < pixel_count; ++p) {
        pixels[p].add(weights[p][k], colour.x, colour.y, colour.z);
        if constexpr (Planes::always_depth) pixels[p].depth = fmaf(weights[p][k], colour.w, pixels[p].depth);
      }
      float of_splat[pixel_count];
#pragma unroll
      for (unsigned p = 0; p < pixel_count; ++p) of_splat[p] = weights[p][k];
      planes.add(queue, first + k, of_splat);
    }
    if constexpr (Planes::depth && !Planes::always_depth)
      if (sums_depth) {
#pragma unroll
        for (unsigned k = 0; k < group_size; ++k)
#pragma unroll
          for (unsigned p = 0; p < pixel_count; ++p)
            pixels[p].depth = fmaf(weights[p][k], colours[k].w, pixels[p].depth);
      }
  }

  /// Leaves out splats of a group that lie at the occluders or behind. Depths do not fall within a group.
  /// Returns a bit for each pixel that would have shown one: it stops there, as where splats are blended one
  /// by one, because a segment that a pixel enters is joined with a rounding. By depths along the ray, which
  /// may fall, it goes on.
  __device__ unsigned hide(float (&alphas)[pixel_count][group_size], const float4* colours,
                           const Queue<Exponent, Planes>& queue, unsigned first) const {
    unsigned hidden = 0;
    if (!(colours[group_size - 1].w >= nearest_occluder())) return hidden;
    if constexpr (Planes::rays)
      if (rays.depths) {
        hide_along_ray(alphas, queue, first);
        return hidden;
      }
#pragma unroll
    for (unsigned p = 0; p < pixel_count; ++p) {
#pragma unroll
      for (unsigned k = 0; k < group_size; ++k) {
        if (!(colours[k].w >= occluders[p])) continue;
        if (alphas[p][k] > 0) hidden |= 1u << p;
        alphas[p][k] = 0;
      }
    }
    return hidden;
  }

  __device__ void hide_along_ray(float (&alphas)[pixel_count][group_size],
                                 const Queue<Exponent, Planes>& queue, unsigned first) const {
    // A bit for each splat that a pixel shows: an index into `alphas` would have them in memory.
    unsigned shown = 0;
#pragma unroll
    for (unsigned i = 0; i < pixel_count * group_size; ++i)
      if (alphas[i % pixel_count][i / pixel_count] > 0) shown |= 1u << i;
    for (unsigned left = shown; left != 0; left &= left - 1) {
      const unsigned i = unsigned(__ffs(int(left))) - 1;
      if (rays.hide(queue.ids[first + i / pixel_count], i % pixel_count)) shown &= ~(1u << i);
    }
#pragma unroll
    for (unsigned i = 0; i < pixel_count * group_size; ++i)
      if (!(shown >> i & 1)) alphas[i % pixel_count][i / pixel_count] = 0;
  }

  __device__ void stop(unsigned pixels_to_stop) {
    if (pixels_to_stop == 0) return;
#pragma unroll
    for (unsigned p = 0; p < pixel_count; ++p)
      if (pixels_to_stop >> p & 1 && pixels[p].live()) pixels[p].stop();
  }
};

/// Blends colours into a warp block. Holds the pixels of this lane.
template <class Exponent, bool threshold, class Planes>
struct ColourBlender {
  static constexpr bool in_segments = true;
  const RasterJob& job;
  Queue<Exponent, Planes>& queue;
  LaneBlender<Exponent, threshold, Planes, pixels_of_lane> lane;

  __device__ void fill(unsigned slot, std::uint32_t id) const { queue.fetch(job, slot, id); }

  /// Waits for the colours of queued splats.
  __device__ void await_queued() const {
    __pipeline_commit();
    __pipeline_wait_prior(0);
    __syncwarp();
  }

  /// Blends `count` splats from `first` on. May overwrite slots behind them.
  __device__ void blend_queued(unsigned first, unsigned count) {
    // Pad the last group with splats that show nothing.
    if constexpr (!Planes::one_by_one) {
      if (lane_index() < (group_size - count % group_size) % group_size)
        queue.clear(first + count + lane_index());
      __syncwarp();
    }
    lane.blend_queued(queue, first, count);
    __syncwarp();
  }

  __device__ bool all_stopped() const { return lane.all_stopped(); }
};

}  // namespace swiftgs::kernels
