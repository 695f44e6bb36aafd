// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <swiftgs/raster/store.hpp>

#include "list_traversal.cuh"

/// @file
/// What pixels hold beside colour: a depth, occluders that hide by depths, and what accumulators add up.
///
/// An accumulator is a type with these members, of which each does its part of what the member of
/// `PixelPlanes` does: `takes_ids`, if it needs the numbers of queued splats, and `fills_queues`, if the sums
/// of segments lie in the queues of the warps that blended them; `Queued`, of queued splats; `Lane`, of a
/// lane's pixels within a segment; `Before`, in front of a segment; `Segments`, of the pixels of blended
/// segments; `Joined`, of pixels behind the segments joined so far; and `Channel`, of a thread that joins
/// segments.

namespace swiftgs::kernels {

/// Depths that a kernel sums in `Pixel::depth` and hides splats by.
enum class Depths {
  none,      ///< colour and alpha alone
  of_means,  ///< every splat has the depth of its mean
  of_rays,   ///< the same, unless a view's occluder hides by depths along the ray
};

/// Occluders of a lane's pixels that hide by depths along the ray. `along_ray.cuh` has those of kernels that
/// take `some`.
template <bool some, unsigned pixel_count>
struct LaneRays;
template <unsigned pixel_count>
struct LaneRays<false, pixel_count> {
  __device__ LaneRays(const RasterJob&, const View&) {}
  __device__ void put(const View&, int, int) {}
  __device__ float take(unsigned, float occluder) { return occluder; }
};

/// Takes a pixel from units of alpha_max to plain ones. All kernels round alike.
__device__ inline BlendedPixel plain_pixel(BlendedPixel pixel, const BlendRules& rules) {
  for (int c = 0; c < 3; ++c) pixel.colour[c] = multiply_rounded(pixel.colour[c], rules.alpha_max);
  pixel.depth = multiply_rounded(pixel.depth, rules.alpha_max);
  return pixel;
}

/// Numbers in the frame of queued splats.
template <bool some>
struct QueuedIds {
  __device__ void put(unsigned, std::uint32_t) {}
};
template <>
struct QueuedIds<true> {
  alignas(16) std::uint32_t ids[queue_size];
  __device__ void put(unsigned slot, std::uint32_t id) { ids[slot] = id; }
};

template <Depths depths, class... Accumulators>
struct PixelPlanes {
  static constexpr bool depth = depths != Depths::none, rays = depths == Depths::of_rays;
  /// Whether depths are summed in every frame.
  static constexpr bool always_depth = depths == Depths::of_means && sizeof...(Accumulators) == 0;
  static constexpr bool fills_queues = (false || ... || Accumulators::fills_queues);
  /// Whether splats are blended one by one, not in groups.
  static constexpr bool one_by_one = rays && !fills_queues;
  /// Thread blocks of `raster_warps` that a multiprocessor holds at once; some representations take fewer.
  /// Measured on an H100 when chosen, frames of herz and of `builtin:4000000` over those of colour alone:
  /// with depth 1.02 and 1.08, with nine blocks 1.12 and 1.13; with picks 1.16 and 1.20, with seven 1.16 and
  /// 1.26; with a row 1.20 and 1.19, with seven 1.30 and 1.29; with rows 1.84 and 1.70, with five 1.90 and
  /// 1.93.
  static constexpr unsigned most_blocks =
      !depth || one_by_one ? 9 : std::min({8u, Accumulators::blocks...}) - (sizeof...(Accumulators) > 1);
  /// Whether these are colour, alpha and depth alone.
  static constexpr bool few = !rays && sizeof...(Accumulators) == 0;

  /// What blending needs of queued splats.
  struct Queued : QueuedIds<(rays || ... || Accumulators::takes_ids)>, Accumulators::Queued... {
    /// Starts loading those of a splat.
    __device__ void fetch_planes(const RasterJob& job, unsigned slot, std::uint32_t id) {
      this->put(slot, id);
      (Accumulators::Queued::fetch(job, slot, id), ...);
    }
    /// Fills a slot with those of a splat that shows nothing.
    __device__ void clear_planes(unsigned slot) { (Accumulators::Queued::clear(slot), ...); }
  };

  /// What lies in front of a segment of a pixel.
  struct Before : Accumulators::Before... {
    /// Enters segment k, which has transmittance `before` in front of it.
    __device__ void enter(float before, std::uint32_t k) { (Accumulators::Before::enter(before, k), ...); }
    /// Passes this segment, which leaves `left`.
    __device__ void pass(float before, std::uint32_t k, float left) {
      (Accumulators::Before::pass(before, k, left), ...);
    }
    /// Whether an entered segment that leaves `left` differs from one that was entered with a bound.
    __device__ bool differs(float left) const {
      return (false || ... || Accumulators::Before::differs(left));
    }
  };

  /// Of the pixels of a lane within a segment.
  template <unsigned pixel_count>
  struct Lane : Accumulators::template Lane<pixel_count>... {
    /// Starts the first segment.
    __device__ explicit Lane(const View& view) : Accumulators::template Lane<pixel_count>(view)... {}
    /// Starts a segment of a pixel.
    __device__ void start(unsigned p, const Before& before) {
      (Accumulators::template Lane<pixel_count>::start(p, before), ...);
    }
    /// Ends a segment that leaves `left`, and writes pixel `at` of the blended segments.
    template <class Segments>
    __device__ void put(Segments& segments, Queued& queue, unsigned at, unsigned p, float left) {
      (Accumulators::template Lane<pixel_count>::put(segments, queue, at, p, left), ...);
    }
    /// Takes a splat of this weight, with transmittance `left` in front of it.
    __device__ void offer(unsigned p, std::uint32_t id, float weight, float left) {
      (Accumulators::template Lane<pixel_count>::offer(p, id, weight, left), ...);
    }
    /// Takes a group of splats, from the first-th queued on.
    __device__ void offer_group(const Queued& queue, unsigned first,
                                const float (&weights)[pixel_count][group_size],
                                const float (&left)[pixel_count][group_size + 1]) {
      (Accumulators::template Lane<pixel_count>::offer_group(queue, first, weights, left), ...);
    }
    /// Takes the k-th queued splat of a group, after all were offered that no occluder hides.
    __device__ void add(const Queued& queue, unsigned k, const float (&weights)[pixel_count]) {
      (Accumulators::template Lane<pixel_count>::add(queue, k, weights), ...);
    }
  };

  /// Of the pixels of blended segments.
  template <unsigned count>
  struct Segments : Accumulators::template Segments<count>... {};

  /// Of pixels behind the segments joined so far, in units of alpha_max. Empty where there is colour alone.
  template <unsigned count>
  struct Joined : Accumulators::template Joined<count>... {
    using OfLane = Lane<pixels_of_lane>;

    /// Copies pixel `from` of others.
    template <unsigned others>
    __device__ void copy(unsigned i, const Joined<others>& of, unsigned from) {
      (Accumulators::template Joined<count>::copy(i, of, from), ...);
    }
    /// Ends the first segment of the lane's p-th pixel, which leaves `left`, and sets pixel i to it.
    __device__ void set(unsigned i, OfLane& lane, unsigned p, float left) {
      (Accumulators::template Joined<count>::set(i, lane, p, left), ...);
    }
    /// Ends a further segment, whose unit is `unit`, and joins it.
    __device__ void join(unsigned i, OfLane& lane, unsigned p, float left, float unit) {
      (Accumulators::template Joined<count>::join(i, lane, p, left, unit), ...);
    }
    /// What lies in front of the next segment.
    template <class AnyLane>
    __device__ Before before(unsigned i, const AnyLane& lane, const BlendRules& rules) const {
      return {Accumulators::template Joined<count>::before(i, lane, rules)...};
    }
    /// Starts segment k of a pixel that has transmittance `left` in front of it, or has stopped.
    __device__ void start_next(unsigned i, OfLane& lane, unsigned p, bool live, const BlendRules& rules,
                               float left, std::uint32_t k) const {
      Before before;
      if (live) before = this->before(i, lane, rules), before.enter(left, k);
      lane.start(p, before);
    }

    /// Goes on with the first segment of a pixel, or of one that has stopped in it.
    __device__ void go_on(unsigned i, OfLane& lane, unsigned p, bool live, const BlendRules& rules) const {
      start_next(i, lane, p, live, rules, 1, 0);
      (Accumulators::template Joined<count>::resume(i, lane, p), ...);
    }
    /// Ends it, and joins what came behind `go_on`.
    __device__ void end_rest(unsigned i, OfLane& lane, unsigned p, float left) {
      (Accumulators::template Joined<count>::end_resumed(i, lane, p, left), ...);
    }

    /// Writes pixel i, if it lies in the image.
    __device__ void store(unsigned i, const RasterJob& job, const View& view, const FramePixel& at,
                          const BlendedPixel& pixel) const {
      if (!at.inside) return;
      const auto x = std::size_t(at.x), y = std::size_t(at.y);
      const BlendedPixel plain = plain_pixel(pixel, view.rules);
      if (!(fills_queues && job.only_attributes)) store_pixel(view.frame, x, y, plain, view.background);
      (Accumulators::template Joined<count>::store(i, job, view, x, y, plain.transmittance), ...);
    }
  };

  /// Of a pixel while one thread per channel joins its segments.
  struct Channel : Accumulators::Channel... {
    template <unsigned count>
    __device__ void load(const Joined<count>& joined, unsigned pixel, unsigned channel) {
      (Accumulators::Channel::load(joined, pixel, channel), ...);
    }
    /// Joins pixel `at` of the segments of a thread block, whose unit is `unit`.
    template <class Shared>
    __device__ void join(const Shared& of, unsigned at, unsigned channel, float unit) {
      (Accumulators::Channel::join(of, at, channel, unit), ...);
    }
    template <unsigned count>
    __device__ void store(Joined<count>& joined, unsigned pixel, unsigned channel) const {
      (Accumulators::Channel::store(joined, pixel, channel), ...);
    }
  };
};

}  // namespace swiftgs::kernels
