// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <cuda_pipeline_primitives.h>

#include "list_traversal.cuh"

namespace swiftgs::kernels {

/// Takes a pixel from units of alpha_max to plain ones. All kernels round alike.
__device__ inline BlendedPixel plain_pixel(BlendedPixel pixel, const BlendRules& rules) {
  for (int c = 0; c < 3; ++c) pixel.colour[c] = multiply_rounded(pixel.colour[c], rules.alpha_max);
  pixel.depth = multiply_rounded(pixel.depth, rules.alpha_max);
  return pixel;
}

/// Writes a pixel in units of alpha_max, if it lies in the image.
__device__ inline void store_relative(const View& view, const PixelPlace& at, const BlendedPixel& pixel) {
  if (at.inside)
    store_pixel(view.frame, std::size_t(at.x), std::size_t(at.y), plain_pixel(pixel, view.rules),
                view.background);
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

/// Keeps `variable` in memory: the traversal needs the registers.
template <class T>
__device__ T& in_memory(T& variable) {
  T* at = &variable;
  asm volatile("" : "+l"(at));
  return *at;
}

/// What pixels hold beside colour and depth: `picks` or not, and so many rows of attributes. Only where lists
/// are not shared: helpers would have to join it.
template <bool picks_ = false, unsigned rows_ = 0>
struct PixelPlanes {
  static constexpr bool picks = picks_;
  static constexpr unsigned rows = rows_;
};

/// Ids and attributes of queued splats.
template <class Planes>
struct QueuedPlanes {};
template <unsigned rows>
struct QueuedPlanes<PixelPlanes<true, rows>> {
  alignas(16) std::uint32_t ids[queue_size];
  float4 attributes[rows == 0 ? 1 : rows][rows == 0 ? 1 : queue_size];
};

/// Exponents, colours and planes of queued splats.
template <class Exponent, class Planes = PixelPlanes<>>
struct Queue : TermsQueue<Exponent>, QueuedPlanes<Planes> {
  float4 colours[queue_size];  ///< RGB, depth
};

/// Picks and sums of the pixels of a lane.
template <class Planes, unsigned pixel_count>
struct LanePlanes {
  struct Joined {};
  __device__ void end_segment(unsigned, float) {}
  __device__ void start_segment(unsigned, float, std::uint32_t) {}
  __device__ void store(const RasterJob&, const View& view, const PixelPlace& at, unsigned,
                        const BlendedPixel& pixel) const {
    store_relative(view, at, pixel);
  }
};
template <unsigned rows, unsigned pixel_count>
struct LanePlanes<PixelPlanes<true, rows>, pixel_count> {
  using Queued = QueuedPlanes<PixelPlanes<true, rows>>;
  static constexpr unsigned sum_count = rows == 0 ? 1 : rows;
  /// Of a pixel, behind the segments before this one.
  struct Joined {
    float4 sums[sum_count];
    float unit = 1;  ///< factor of the segment's transmittances and weights
  };
  static constexpr float found = INFINITY;  ///< as a limit that the transmittance has passed

  Joined* joined;  ///< in memory
  bool some_first, some_median, some_largest;
  std::uint32_t first[pixel_count], median[pixel_count], largest[pixel_count];
  // In units of the segment.
  float first_below[pixel_count], half_below[pixel_count];  ///< limits of the transmittance
  float weight[pixel_count];                                ///< of the largest
  float4 sums[pixel_count * sum_count];

  __device__ LanePlanes(Joined (&in)[pixel_count], const View& view)
      : joined(in),
        some_first(view.frame.first_depth.data),
        some_median(view.frame.median_depth.data || view.frame.median_id.data),
        some_largest(view.frame.id.data) {
#pragma unroll
    for (unsigned p = 0; p < pixel_count; ++p) {
      first[p] = median[p] = largest[p] = SplatPicks::none, weight[p] = 0;
      first_below[p] = view.rules.first_below, half_below[p] = median_below;
    }
#pragma unroll
    for (float4& sum : sums) sum = make_float4(0, 0, 0, 0);
    for (unsigned p = 0; p < pixel_count; ++p)
      for (float4& sum : joined[p].sums) sum = make_float4(0, 0, 0, 0);
  }

  /// Joins a pixel's segment, which leaves `left`, to those in front of it.
  __device__ void end_segment(unsigned p, float left) {
    Joined& all = joined[p];
    if (left < first_below[p]) first_below[p] = found;
    if (left < half_below[p]) half_below[p] = found;
    weight[p] *= all.unit;
    if (first_below[p] < found) first_below[p] *= all.unit;
    if (half_below[p] < found) half_below[p] *= all.unit;
#pragma unroll
    for (unsigned r = 0; r < sum_count; ++r) {
      float4 &to = all.sums[r], &from = sums[p * sum_count + r];
      to.x = fmaf(all.unit, from.x, to.x), to.y = fmaf(all.unit, from.y, to.y);
      to.z = fmaf(all.unit, from.z, to.z), to.w = fmaf(all.unit, from.w, to.w);
      from = make_float4(0, 0, 0, 0);
    }
  }
  /// Starts segment k of a pixel that has transmittance `before` in front of it.
  __device__ void start_segment(unsigned p, float before, std::uint32_t k) {
    const float unit = before * scale_of_segment(k), start = 1 / scale_of_segment(k);
    joined[p].unit = unit;
    weight[p] /= unit;
    // No more than where it starts: only a splat takes the transmittance below.
    if (first_below[p] < found) first_below[p] = fminf(first_below[p] / unit, start);
    if (half_below[p] < found) half_below[p] = fminf(half_below[p] / unit, start);
  }

  /// Takes a splat of this weight, with `left` transmittance in front of it. The last one offered above a
  /// limit is the one that passes it.
  __device__ void offer(unsigned p, std::uint32_t id, float splat_weight, float left) {
    if (some_largest && splat_weight > weight[p]) weight[p] = splat_weight, largest[p] = id;
    if (some_median && left >= half_below[p]) median[p] = id;
    if (some_first && left >= first_below[p]) first[p] = id;
  }
  /// Takes a group of splats, from the first-th queued on.
  __device__ void offer_group(const Queued& queue, unsigned first_of_group,
                              const float (&weights)[pixel_count][group_size],
                              const float (&left)[pixel_count][group_size + 1]) {
    static_assert(group_size == 4);
    const uint4 group = *reinterpret_cast<const uint4*>(queue.ids + first_of_group);
    const std::uint32_t ids[group_size] = {group.x, group.y, group.z, group.w};
    const auto each = [&](const auto& take) {
#pragma unroll
      for (unsigned k = 0; k < group_size; ++k)
#pragma unroll
        for (unsigned p = 0; p < pixel_count; ++p) take(p, k);
    };
    // Branches are uniform: one for all pixels of a frame.
    if (some_largest)
      each([&](unsigned p, unsigned k) {
        if (weights[p][k] > weight[p]) weight[p] = weights[p][k], largest[p] = ids[k];
      });
    if (some_median)
      each([&](unsigned p, unsigned k) {
        if (left[p][k] >= half_below[p]) median[p] = ids[k];
      });
    if (some_first)
      each([&](unsigned p, unsigned k) {
        if (left[p][k] >= first_below[p]) first[p] = ids[k];
      });
  }

  /// Adds attributes of the k-th queued splat, by its weights.
  __device__ void add(const Queued& queue, unsigned k, const float (&weights)[pixel_count]) {
#pragma unroll
    for (unsigned r = 0; r < rows; ++r) {
      const float4 row = queue.attributes[r][k];
#pragma unroll
      for (unsigned p = 0; p < pixel_count; ++p) {
        float4& to = sums[p * rows + r];
        to.x = fmaf(weights[p], row.x, to.x), to.y = fmaf(weights[p], row.y, to.y);
        to.z = fmaf(weights[p], row.z, to.z), to.w = fmaf(weights[p], row.w, to.w);
      }
    }
  }

  /// Writes a pixel in units of alpha_max whose last segment has ended, if it lies in the image.
  __device__ void store(const RasterJob& job, const View& view, const PixelPlace& at, unsigned p,
                        const BlendedPixel& pixel) const {
    if (!at.inside) return;
    const auto x = std::size_t(at.x), y = std::size_t(at.y);
    const float* const of_pixel = reinterpret_cast<const float*>(joined[p].sums);
    float plain[sum_count * AttributeRow::channels];
    for (unsigned i = 0; i < sum_count * AttributeRow::channels; ++i)
      plain[i] = multiply_rounded(of_pixel[i], view.rules.alpha_max);
    store_pixel(job, view, x, y, plain_pixel(pixel, view.rules), plain);
    if (!job.picks(view)) return;
    store_picks(view.frame, job.splats, x, y,
                {first_below[p] == found ? first[p] : SplatPicks::none,
                 half_below[p] == found ? median[p] : SplatPicks::none, largest[p]});
  }
};

/// Blends queued splats into one or both pixels of a lane.
template <class Exponent, bool threshold, Extras extras, unsigned pixel_count, class Planes = PixelPlanes<>>
struct LaneBlender {
  BlendRules rules;
  float x, y, right;  ///< first pixel in the warp block; a single pixel lies `right` columns to its right
  Pixel pixels[pixel_count];
  float occluders[pixel_count];
  ThreadCounts counts[pixel_count];
  LanePlanes<Planes, pixel_count> planes;

  /// Blends `count` splats from `first` on: whole groups of `group_size` splats; with all extras, any number.
  __device__ void blend_queued(const Queue<Exponent, Planes>& queue, unsigned first, unsigned count) {
    if constexpr (extras == Extras::all) {
      for (unsigned k = first; k < first + count; ++k) {
        float alphas[pixel_count];
        evaluate(queue.terms[k], queue.rests[k], alphas);
#pragma unroll
        for (unsigned p = 0; p < pixel_count; ++p) {
          const float before = pixels[p].transmittance;
          const float left = Pixel::dimmed_relative(before, alphas[p] * before, rules.alpha_max);
          blend<true>(pixels[p], alphas[p], left, queue.colours[k], occluders[p], counts[p]);
          if constexpr (Planes::picks)
            if (alphas[p] > 0 && pixels[p].live()) planes.offer(p, queue.ids[k], alphas[p] * before, before);
        }
      }
    } else {
      // Advance pointers: an index would cost a multiplication each time.
      const float4 *terms = queue.terms + first, *colours = queue.colours + first;
      const typename Exponent::Rest* rests = queue.rests + first;
#pragma unroll 1
      for (unsigned k = 0; k < count; k += group_size) {
        blend_group(terms, rests, colours, queue, first + k);
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
                              const float4* colours, const Queue<Exponent, Planes>& queue, unsigned first) {
    float alphas[pixel_count][group_size], weights[pixel_count][group_size];
#pragma unroll
    for (unsigned k = 0; k < group_size; ++k) {
      float of_splat[pixel_count];
      evaluate(terms[k], rests[k], of_splat);
#pragma unroll
      for (unsigned p = 0; p < pixel_count; ++p) alphas[p][k] = of_splat[p];
    }
    const unsigned hidden = extras != Extras::none ? hide(alphas, colours) : 0;
    float left[pixel_count][group_size + 1];
    weigh_group(pixels, alphas, rules.alpha_max, weights, left);
    if constexpr (Planes::picks) planes.offer_group(queue, first, weights, left);
    stop(hidden);

#pragma unroll
    for (unsigned k = 0; k < group_size; ++k) {
      const float4 colour = colours[k];
#pragma unroll
      for (unsigned p = 0; p < pixel_count; ++p) {
        pixels[p].add(weights[p][k], colour.x, colour.y, colour.z);
        if constexpr (extras != Extras::none)
          pixels[p].depth = fmaf(weights[p][k], colour.w, pixels[p].depth);
      }
      if constexpr (Planes::rows != 0) {
        float of_splat[pixel_count];
#pragma unroll
        for (unsigned p = 0; p < pixel_count; ++p) of_splat[p] = weights[p][k];
        planes.add(queue, first + k, of_splat);
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
template <class Exponent, class Planes>
__device__ void fetch_colour(const RasterJob& job, Queue<Exponent, Planes>& queue, unsigned slot,
                             std::uint32_t id) {
  __pipeline_memcpy_async(&queue.colours[slot], job.colours.each.data + id, sizeof(float4));
}

/// Blends colours into a warp block. Holds the pixels of this lane.
template <class Exponent, bool threshold, Extras extras, class Planes>
struct ColourBlender {
  static constexpr bool in_segments = true;
  const RasterJob& job;
  Queue<Exponent, Planes>& queue;
  LaneBlender<Exponent, threshold, extras, pixels_of_lane, Planes> lane;

  __device__ void fill(unsigned slot, std::uint32_t id) const {
    fetch_colour(job, queue, slot, id);
    if constexpr (Planes::picks) queue.ids[slot] = id;
    if constexpr (Planes::rows != 0) {
#pragma unroll
      for (unsigned r = 0; r < Planes::rows; ++r)
        __pipeline_memcpy_async(&queue.attributes[r][slot], &job.attributes.row(r, id), sizeof(float4));
    }
  }

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
        if constexpr (Planes::rows != 0)
          for (float4(&row)[queue_size] : queue.attributes) row[at] = make_float4(0, 0, 0, 0);
      }
      __syncwarp();
    }
    lane.blend_queued(queue, first, count);
    __syncwarp();
  }

  __device__ bool all_stopped() const { return lane.all_stopped(); }
};

}  // namespace swiftgs::kernels
