// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <cuda_pipeline_primitives.h>

#include "list_traversal.cuh"

namespace swiftgs::kernels {

/// Writes a pixel that lies in the image; its colour and depth are in units of alpha_max. All kernels round
/// alike.
__device__ inline void store_relative(const View& view, const PixelPlace& at, BlendedPixel pixel) {
  if (!at.inside) return;
  const float alpha_max = view.rules.alpha_max;
  for (int c = 0; c < 3; ++c) pixel.colour[c] = multiply_rounded(pixel.colour[c], alpha_max);
  pixel.depth = multiply_rounded(pixel.depth, alpha_max);
  store_pixel(view.frame, std::size_t(at.x), std::size_t(at.y), pixel, view.background);
}

__device__ inline ThreadCounts sum(const ThreadCounts (&of_pixels)[pixels_of_lane]) {
  ThreadCounts all;
  for (const ThreadCounts& one : of_pixels) all.pairs += one.pairs, all.stopped += one.stopped;
  return all;
}

/// Whether all pixels of the warp stopped.
template <unsigned count>
__device__ bool all_stopped(const Pixel (&pixels)[count]) {
  bool stopped = true;
  for (const Pixel& pixel : pixels) stopped = stopped && !pixel.live();
  return __all_sync(whole_warp, stopped);
}

/// Depth of splats that show nothing and end a group: behind all others.
inline constexpr float padded_depth = 3.4028235e38f;
__device__ inline float4 no_colour() { return make_float4(0, 0, 0, padded_depth); }

/// Exponents and colours of queued splats.
template <class Exponent>
struct Queue : TermsQueue<Exponent> {
  float4 colours[queue_size];  ///< RGB, depth
};

/// Blends queued splats into one or both pixels of a lane.
template <class Exponent, bool threshold, Extras extras, unsigned pixel_count>
struct LaneBlender {
  BlendRules rules;
  float x, y, right;  ///< first pixel in the warp block; a single pixel lies `right` columns to its right
  Pixel pixels[pixel_count];
  float occluders[pixel_count];
  ThreadCounts counts[pixel_count];

  /// Blends `count` splats from `first` on: whole groups of `group_size` splats; with all extras, any number.
  __device__ void blend_queued(const Queue<Exponent>& queue, unsigned first, unsigned count) {
    if constexpr (extras == Extras::all) {
      for (unsigned k = first; k < first + count; ++k) {
        float alphas[pixel_count];
        evaluate(queue.terms[k], queue.rests[k], alphas);
#pragma unroll
        for (unsigned p = 0; p < pixel_count; ++p) {
          const float before = pixels[p].transmittance;
          const float left = Pixel::dimmed_relative(before, alphas[p] * before, rules.alpha_max);
          blend<true>(pixels[p], alphas[p], left, queue.colours[k], occluders[p], counts[p]);
        }
      }
    } else {
      // Advance pointers: an index would cost a multiplication each time.
      const float4 *terms = queue.terms + first, *colours = queue.colours + first;
      const typename Exponent::Rest* rests = queue.rests + first;
#pragma unroll 1
      for (unsigned k = 0; k < count; k += group_size) {
        blend_group(terms, rests, colours);
        terms += group_size, rests += group_size, colours += group_size;
      }
    }
  }

  __device__ bool all_stopped() const { return kernels::all_stopped(pixels); }

 private:
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

  __device__ void blend_group(const float4* terms, const typename Exponent::Rest* rests,
                              const float4* colours) {
    float alphas[pixel_count][group_size], weights[pixel_count][group_size];
#pragma unroll
    for (unsigned k = 0; k < group_size; ++k) {
      float of_splat[pixel_count];
      evaluate(terms[k], rests[k], of_splat);
#pragma unroll
      for (unsigned p = 0; p < pixel_count; ++p) alphas[p][k] = of_splat[p];
    }
    const unsigned hidden = extras == Extras::depth ? hide(alphas, colours) : 0;
    weigh_group(pixels, alphas, rules.alpha_max, weights);
    stop(hidden);

#pragma unroll
    for (unsigned k = 0; k < group_size; ++k) {
      const float4 colour = colours[k];
#pragma unroll
      for (unsigned p = 0; p < pixel_count; ++p) {
        pixels[p].add(weights[p][k], colour.x, colour.y, colour.z);
        if constexpr (extras == Extras::depth)
          pixels[p].depth = fmaf(weights[p][k], colour.w, pixels[p].depth);
      }
    }
  }

  /// Leaves out splats of a group that lie at the occluders or behind. Depths do not fall within a group.
  /// Returns a bit for each pixel that would have shown one: it stops there, as where splats are blended one
  /// by one, because a segment that a pixel enters is joined with a rounding.
  __device__ unsigned hide(float (&alphas)[pixel_count][group_size], const float4* colours) const {
    float nearest = occluders[0];
    if constexpr (pixel_count == 2) nearest = fminf(nearest, occluders[1]);
    unsigned hidden = 0;
    if (!(colours[group_size - 1].w >= nearest)) return hidden;
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

  __device__ void stop(unsigned pixels_to_stop) {
    if (pixels_to_stop == 0) return;
#pragma unroll
    for (unsigned p = 0; p < pixel_count; ++p)
      if (pixels_to_stop >> p & 1 && pixels[p].live()) pixels[p].stop();
  }
};

/// Starts loading the colour of a queued splat.
template <class Exponent>
__device__ void fetch_colour(const RasterJob& job, Queue<Exponent>& queue, unsigned slot, std::uint32_t id) {
  __pipeline_memcpy_async(&queue.colours[slot], job.colours.each.data + id, sizeof(float4));
}

/// Blends colours into a warp block. Holds the pixels of this lane.
template <class Exponent, bool threshold, Extras extras>
struct ColourBlender {
  static constexpr bool in_segments = true;
  const RasterJob& job;
  Queue<Exponent>& queue;
  LaneBlender<Exponent, threshold, extras, pixels_of_lane> lane;

  __device__ void fill(unsigned slot, std::uint32_t id) const { fetch_colour(job, queue, slot, id); }

  /// Waits for the colours of queued splats.
  __device__ void await_queued() const {
    __pipeline_commit();
    __pipeline_wait_prior(0);
    __syncwarp();
  }

  /// Blends `count` splats from `first` on. May overwrite slots behind them.
  __device__ void blend_queued(unsigned first, unsigned count) {
    // Pad the last group with splats that show nothing.
    if constexpr (extras != Extras::all) {
      if (lane_index() < (group_size - count % group_size) % group_size) {
        const unsigned at = first + count + lane_index();
        Exponent::clear(queue.terms[at], queue.rests[at]);
        queue.colours[at] = no_colour();
      }
      __syncwarp();
    }
    lane.blend_queued(queue, first, count);
    __syncwarp();
  }

  __device__ bool all_stopped() const { return lane.all_stopped(); }
};

}  // namespace swiftgs::kernels
