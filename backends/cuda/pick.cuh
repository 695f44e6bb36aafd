// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

#include <swiftgs/plane/picks.hpp>

#include "accumulators.cuh"
#include "segment_picks.hpp"

namespace swiftgs::kernels {

/// Remembers splats: the first that shows, the median and the one of the largest weight.
struct Pick {
  static constexpr bool takes_ids = true, fills_queues = false;
  static constexpr unsigned blocks = 6;

  struct Queued {
    __device__ void fetch(const RasterJob&, unsigned, std::uint32_t) {}
    __device__ void clear(unsigned) {}
  };

  struct Before {
    PickLimits limits{};  ///< passed where the transmittance in front of the segment is only a bound

    __device__ void enter(float before, std::uint32_t k) { limits = limits.in_segment(before, k); }
    __device__ void pass(float before, std::uint32_t k, float left) {
      limits = limits.behind(limits.in_segment(before, k), left);
    }
    __device__ bool differs(float left) const { return limits.some_above(left); }
  };

  template <unsigned pixel_count>
  struct Lane {
    bool some_first, some_median, some_largest;
    PickLimits limits[pixel_count];
    std::uint32_t first[pixel_count], median[pixel_count], largest[pixel_count];
    float weight[pixel_count];  ///< of the largest

    __device__ explicit Lane(const View& view)
        : some_first(view.frame.first_depth.data),
          some_median(view.frame.median_depth.data || view.frame.median_id.data),
          some_largest(view.frame.id.data) {
#pragma unroll
      for (unsigned p = 0; p < pixel_count; ++p) start(p, {whole_limits(view.rules).in_segment(1, 0)});
    }

    /// Of the whole list.
    __device__ PickLimits whole_limits(const BlendRules& rules) const {
      return {some_first ? rules.first_below : PickLimits::passed,
              some_median ? median_below : PickLimits::passed};
    }
    __device__ void start(unsigned p, const Before& before) {
      first[p] = median[p] = largest[p] = SplatPicks::none, weight[p] = 0;
      limits[p] = before.limits;
    }
    /// Ends the segment of a pixel, which leaves `left`.
    __device__ JoinedPicks end(unsigned p, float left) {
      if (!(left < limits[p].first)) first[p] = SplatPicks::none;
      if (!(left < limits[p].median)) median[p] = SplatPicks::none;
      return {first[p], median[p], largest[p], weight[p]};
    }
    template <class Segments, class Queue>
    __device__ void put(Segments& segments, Queue&, unsigned at, unsigned p, float left) {
      segments.picks[at] = end(p, left);
    }

    __device__ void offer(unsigned p, std::uint32_t id, float splat_weight, float left) {
      if (some_largest && splat_weight > weight[p]) weight[p] = splat_weight, largest[p] = id;
      if (some_median && left >= limits[p].median) median[p] = id;
      if (some_first && left >= limits[p].first) first[p] = id;
    }
    __device__ void offer_group(const QueuedIds<true>& queue, unsigned first_of_group,
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
          if (left[p][k] >= limits[p].median) median[p] = ids[k];
        });
      if (some_first)
        each([&](unsigned p, unsigned k) {
          if (left[p][k] >= limits[p].first) first[p] = ids[k];
        });
    }
    template <class Queue>
    __device__ void add(const Queue&, unsigned, const float (&)[pixel_count]) {}
  };

  template <unsigned count>
  struct Joined {
    JoinedPicks picks[count];

    template <unsigned others>
    __device__ void copy(unsigned i, const Joined<others>& of, unsigned from) {
      picks[i] = of.picks[from];
    }
    __device__ void set(unsigned i, Lane<pixels_of_lane>& lane, unsigned p, float left) {
      picks[i] = lane.end(p, left);
    }
    __device__ void join(unsigned i, Lane<pixels_of_lane>& lane, unsigned p, float left, float unit) {
      JoinedPicks all = picks[i];
      all.join(lane.end(p, left), unit);
      picks[i] = all;
    }
    template <class AnyLane>
    __device__ Before before(unsigned i, const AnyLane& lane, const BlendRules& rules) const {
      return {lane.whole_limits(rules).behind(picks[i])};
    }
    __device__ void resume(unsigned, Lane<pixels_of_lane>&, unsigned) const {}
    __device__ void end_resumed(unsigned i, Lane<pixels_of_lane>& lane, unsigned p, float left) {
      join(i, lane, p, left, 1);
    }
    __device__ void store(unsigned i, const RasterJob& job, const View& view, std::size_t x, std::size_t y,
                          float) const {
      if (const JoinedPicks& of = picks[i]; job.picks(view))
        store_picks(job, view, x, y, {of.first, of.median, of.largest});
    }
  };

  template <unsigned count>
  struct Segments {
    JoinedPicks picks[count];
  };

  struct Channel {
    JoinedPicks picks;

    template <unsigned count>
    __device__ void load(const Joined<count>& joined, unsigned pixel, unsigned) {
      picks = joined.picks[pixel];
    }
    template <class Shared>
    __device__ void join(const Shared& of, unsigned at, unsigned, float scaled) {
      picks.join(of.planes_of_segments.picks[at], scaled);
    }
    template <unsigned count>
    __device__ void store(Joined<count>& joined, unsigned pixel, unsigned channel) const {
      if (channel == 0) joined.picks[pixel] = picks;
    }
  };
};

}  // namespace swiftgs::kernels
