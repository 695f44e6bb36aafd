// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <cuda_pipeline_primitives.h>

#include <swiftgs/raster/store.hpp>

#include "list_traversal.cuh"
#include "segment_picks.hpp"

/// @file
/// What pixels hold beside colour and depth.

namespace swiftgs::kernels {

/// Takes a pixel from units of alpha_max to plain ones. All kernels round alike.
__device__ inline BlendedPixel plain_pixel(BlendedPixel pixel, const BlendRules& rules) {
  for (int c = 0; c < 3; ++c) pixel.colour[c] = multiply_rounded(pixel.colour[c], rules.alpha_max);
  pixel.depth = multiply_rounded(pixel.depth, rules.alpha_max);
  return pixel;
}

/// `picks` or not, so many rows of attributes, and depths along the ray for occluders.
template <bool picks_ = false, unsigned rows_ = 0, bool rays_ = false>
struct PixelPlanes {
  static constexpr bool picks = picks_, rays = rays_;
  static constexpr unsigned rows = rows_;
};
template <Extras extras>
using PlanesOf =
    PixelPlanes<picks_of(extras), rows_of(extras), rows_of(extras) != 0 || extras == Extras::picks_along_ray>;

/// Calls a generic f(r) for each row. It is not compiled where there is none.
template <unsigned rows, class F>
__device__ void for_each_row(const F& f) {
  if constexpr (rows != 0) {
#pragma unroll
    for (unsigned r = 0; r < rows; ++r) f(r);
  }
}

__device__ inline void add_scaled(float4& to, float factor, const float4& from) {
  to.x = fmaf(factor, from.x, to.x), to.y = fmaf(factor, from.y, to.y);
  to.z = fmaf(factor, from.z, to.z), to.w = fmaf(factor, from.w, to.w);
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

/// Attributes of queued splats.
template <unsigned rows>
struct QueuedRows {
  float4 attributes[rows][queue_size];

  /// Starts loading them.
  __device__ void fetch(const RasterJob& job, unsigned slot, std::uint32_t id) {
    for_each_row<rows>([&](auto r) {
      if (rows == 1 || r < job.attributes.rows)
        __pipeline_memcpy_async(&attributes[r][slot], &job.attributes.row(r, id), sizeof(float4));
      else
        attributes[r][slot] = make_float4(0, 0, 0, 0);
    });
  }
  /// Those of a splat that shows nothing.
  __device__ void clear(unsigned slot) {
    for_each_row<rows>([&](auto r) { attributes[r][slot] = make_float4(0, 0, 0, 0); });
  }
};
template <>
struct QueuedRows<0> {
  static float4 attributes[1][queue_size];  ///< a name alone: nothing reads it
  __device__ void fetch(const RasterJob&, unsigned, std::uint32_t) {}
  __device__ void clear(unsigned) {}
};

/// What blending needs of queued splats for planes.
template <class Planes>
struct QueuedPlanes : QueuedIds<Planes::picks || Planes::rays>, QueuedRows<Planes::rows> {
  __device__ void fetch_planes(const RasterJob& job, unsigned slot, std::uint32_t id) {
    this->put(slot, id);
    QueuedRows<Planes::rows>::fetch(job, slot, id);
  }
  __device__ void clear_planes(unsigned slot) { QueuedRows<Planes::rows>::clear(slot); }
};

/// Occluders of a lane's pixels that hide by depths along the ray.
template <bool some, unsigned pixel_count>
struct LaneRays {
  __device__ LaneRays(const RasterJob&, const View&) {}
  __device__ void put(const View&, int, int) {}
  __device__ float take(unsigned, float occluder) { return occluder; }
};
/// Volatile, so in memory: few frames need it, and the loop over splats needs the registers. With registers,
/// frames of fox and herz with normals take 13 % longer (measured on an H100).
template <unsigned pixel_count>
struct LaneRays<true, pixel_count> {
  const AttributeRow* volatile depths;  ///< of all splats; null where means decide
  volatile unsigned stride;             ///< from one splat's to the next
  volatile float x, y;                  ///< `place_of` the first pixel
  volatile float occluders[pixel_count];

  __device__ LaneRays(const RasterJob& job, const View& view)
      : depths(hides_along_ray(view) ? job.attributes.first_row : nullptr),
        stride(job.attributes.first_stride) {}

  /// Tells where the first pixel lies in the frame.
  __device__ void put(const View& view, int x_in_frame, int y_in_frame) {
    const vec2 place = place_of(view, std::size_t(x_in_frame), std::size_t(y_in_frame));
    x = place.x, y = place.y;
  }
  /// Takes the occluder of the p-th pixel. Returns the one for depths of means; along the ray this is
  /// -infinity, so that every splat is tested here.
  __device__ float take(unsigned p, float occluder) {
    occluders[p] = occluder;
    return depths ? -INFINITY : occluder;
  }

  /// Whether the p-th pixel does not show a splat.
  __device__ bool hide(std::uint32_t id, unsigned p) const {
    const float4 row = *reinterpret_cast<const float4*>(depths + std::size_t(id) * stride);
    const vec2 place(x + float(p * columns_between), y);
    // A variable index would have all that a lane holds in memory.
    const float occluder = p == 0 ? occluders[0] : occluders[pixel_count - 1];
    return RayDepth{row.x, row.y, row.z}.at(place) >= occluder;
  }
};

/// Picks of the pixels of a lane within a segment.
template <bool some, unsigned pixel_count>
struct LanePicks {
  __device__ explicit LanePicks(const View&) {}
  __device__ void start(unsigned, const PickLimits&) {}
};
template <unsigned pixel_count>
struct LanePicks<true, pixel_count> {
  bool some_first, some_median, some_largest;
  PickLimits limits[pixel_count];
  std::uint32_t first[pixel_count], median[pixel_count], largest[pixel_count];
  float weight[pixel_count];  ///< of the largest

  __device__ explicit LanePicks(const View& view)
      : some_first(view.frame.first_depth.data),
        some_median(view.frame.median_depth.data || view.frame.median_id.data),
        some_largest(view.frame.id.data) {
#pragma unroll
    for (unsigned p = 0; p < pixel_count; ++p) start(p, whole_limits(view.rules).in_segment(1, 0));
  }

  /// Of the whole list.
  __device__ PickLimits whole_limits(const BlendRules& rules) const {
    return {some_first ? rules.first_below : PickLimits::passed,
            some_median ? median_below : PickLimits::passed};
  }

  /// Starts a segment of a pixel.
  __device__ void start(unsigned p, const PickLimits& in_segment) {
    first[p] = median[p] = largest[p] = SplatPicks::none, weight[p] = 0;
    limits[p] = in_segment;
  }
  /// Ends the segment of a pixel, which leaves `left`.
  __device__ void end(unsigned p, float left) {
    if (!(left < limits[p].first)) first[p] = SplatPicks::none;
    if (!(left < limits[p].median)) median[p] = SplatPicks::none;
  }
  /// Of an ended segment.
  __device__ JoinedPicks picks(unsigned p) const { return {first[p], median[p], largest[p], weight[p]}; }

  /// Takes a splat of this weight, with transmittance `left` in front of it.
  __device__ void offer(unsigned p, std::uint32_t id, float splat_weight, float left) {
    if (some_largest && splat_weight > weight[p]) weight[p] = splat_weight, largest[p] = id;
    if (some_median && left >= limits[p].median) median[p] = id;
    if (some_first && left >= limits[p].first) first[p] = id;
  }
  /// Takes a group of splats, from the first-th queued on.
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
};

/// Sums of attributes of the pixels of a lane within a segment.
template <unsigned rows, unsigned pixel_count>
struct LaneSums {
  float4 sums[pixel_count * (rows == 0 ? 1 : rows)];

  __device__ void start(unsigned p) {
    for_each_row<rows>([&](auto r) { sums[p * rows + r] = make_float4(0, 0, 0, 0); });
  }
  /// Adds attributes of the k-th queued splat, by its weights.
  __device__ void add(const QueuedRows<rows>& queue, unsigned k, const float (&weights)[pixel_count]) {
    for_each_row<rows>([&](auto r) {
      const float4 row = queue.attributes[r][k];
#pragma unroll
      for (unsigned p = 0; p < pixel_count; ++p) add_scaled(sums[p * rows + r], weights[p], row);
    });
  }
};

/// Picks and sums of the pixels of a lane within a segment.
template <class Planes, unsigned pixel_count>
struct LanePlanes : LanePicks<Planes::picks, pixel_count>, LaneSums<Planes::rows, pixel_count> {
  using Picks = LanePicks<Planes::picks, pixel_count>;
  using Sums = LaneSums<Planes::rows, pixel_count>;

  /// Starts the first segment.
  __device__ explicit LanePlanes(const View& view) : Picks(view) {
#pragma unroll
    for (unsigned p = 0; p < pixel_count; ++p) Sums::start(p);
  }
  /// Starts a segment of a pixel.
  __device__ void start(unsigned p, const PickLimits& in_segment) {
    Picks::start(p, in_segment), Sums::start(p);
  }
};

template <bool some, unsigned count>
struct JoinedPicksOf {};
template <unsigned count>
struct JoinedPicksOf<true, count> {
  JoinedPicks picks[count];
};
template <unsigned rows, unsigned count>
struct JoinedSumsOf {
  float4 sums[rows][count];
};
template <unsigned count>
struct JoinedSumsOf<0, count> {
  static float4 sums[1][count];  ///< a name alone: nothing reads it
};

/// Planes of pixels behind the segments joined so far, in units of alpha_max. Empty where there is colour
/// alone.
template <class Planes, unsigned count>
struct JoinedPlanes : JoinedPicksOf<Planes::picks, count>, JoinedSumsOf<Planes::rows, count> {
  using Lane = LanePlanes<Planes, pixels_of_lane>;
  static constexpr bool has_picks = Planes::picks;
  static constexpr unsigned rows = Planes::rows;

  /// Copies pixel `from` of others.
  template <unsigned others>
  __device__ void copy(unsigned i, const JoinedPlanes<Planes, others>& of, unsigned from) {
    if constexpr (has_picks) this->picks[i] = of.picks[from];
    for_each_row<rows>([&](auto r) { this->sums[r][i] = of.sums[r][from]; });
  }
  /// Ends the first segment of the lane's p-th pixel, which leaves `left`, and sets pixel i to it.
  __device__ void set(unsigned i, Lane& lane, unsigned p, float left) {
    if constexpr (has_picks) lane.end(p, left), this->picks[i] = lane.picks(p);
    for_each_row<rows>([&](auto r) { this->sums[r][i] = lane.sums[p * rows + r]; });
  }
  /// Ends a further segment, whose unit is `unit`, and joins it.
  __device__ void join(unsigned i, Lane& lane, unsigned p, float left, float unit) {
    if constexpr (has_picks) {
      lane.end(p, left);
      JoinedPicks all = this->picks[i];
      all.join(lane.picks(p), unit);
      this->picks[i] = all;
    }
    for_each_row<rows>([&](auto r) { add_scaled(this->sums[r][i], unit, lane.sums[p * rows + r]); });
  }
  /// Starts segment k of a pixel that has transmittance `before` in front of it, or has stopped.
  __device__ void start_next(unsigned i, Lane& lane, unsigned p, bool live, const BlendRules& rules,
                             float before, std::uint32_t k) const {
    PickLimits limits;
    if constexpr (has_picks)
      if (live) limits = lane.whole_limits(rules).behind(this->picks[i]).in_segment(before, k);
    lane.start(p, limits);
  }

  /// Goes on with the first segment of a pixel, or of one that has stopped in it.
  __device__ void go_on(unsigned i, Lane& lane, unsigned p, bool live, const BlendRules& rules) const {
    start_next(i, lane, p, live, rules, 1, 0);
    for_each_row<rows>([&](auto r) { lane.sums[p * rows + r] = this->sums[r][i]; });
  }
  /// Ends it, and joins what came behind `go_on`.
  __device__ void end_rest(unsigned i, Lane& lane, unsigned p, float left) {
    if constexpr (has_picks) {
      JoinedPicks all = this->picks[i];
      set(i, lane, p, left);
      all.join(this->picks[i], 1);
      this->picks[i] = all;
    } else {
      set(i, lane, p, left);
    }
  }

  /// Writes pixel i, if it lies in the image.
  __device__ void store(unsigned i, const RasterJob& job, const View& view, const PixelPlace& at,
                        const BlendedPixel& pixel) const {
    if (!at.inside) return;
    const auto x = std::size_t(at.x), y = std::size_t(at.y);
    const BlendedPixel plain = plain_pixel(pixel, view.rules);
    if constexpr (rows == 0) {
      store_pixel(view.frame, x, y, plain, view.background);
    } else {
      float plain_sums[rows * AttributeRow::channels];
      for_each_row<rows>([&](auto r) {
        const float4 row = this->sums[r][i];
        const float of_row[] = {row.x, row.y, row.z, row.w};
#pragma unroll
        for (unsigned c = 0; c < AttributeRow::channels; ++c)
          plain_sums[r * AttributeRow::channels + c] = multiply_rounded(of_row[c], view.rules.alpha_max);
      });
      store_pixel(job, view, x, y, plain, plain_sums);
    }
    if constexpr (has_picks)
      if (const JoinedPicks& of = this->picks[i]; job.picks(view))
        store_picks(job, view, x, y, {of.first, of.median, of.largest});
  }
};

}  // namespace swiftgs::kernels
