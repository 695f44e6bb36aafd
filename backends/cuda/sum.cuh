// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <cuda_pipeline_primitives.h>

#include <swiftgs/plane/attributes.hpp>

#include "accumulators.cuh"

namespace swiftgs::kernels {

__device__ inline void add_scaled(float4& to, float factor, const float4& from) {
  to.x = fmaf(factor, from.x, to.x), to.y = fmaf(factor, from.y, to.y);
  to.z = fmaf(factor, from.z, to.z), to.w = fmaf(factor, from.w, to.w);
}

/// Sums so many rows of attributes by weight: normals, features, depths along the ray.
template <unsigned rows>
struct Sum {
  static constexpr bool takes_ids = false, fills_queues = true;
  static constexpr unsigned blocks = rows == 1 ? 6 : 4;

  /// Calls a generic f(r) for each row.
  template <class F>
  __device__ static void for_each_row(const F& f) {
#pragma unroll
    for (unsigned r = 0; r < rows; ++r) f(r);
  }

  struct Queued {
    float4 attributes[rows][queue_size];

    __device__ void fetch(const RasterJob& job, unsigned slot, std::uint32_t id) {
      for_each_row([&](auto r) {
        if (rows == 1 || r < job.attributes.rows)
          __pipeline_memcpy_async(&attributes[r][slot], &job.attributes.row(r, id), sizeof(float4));
        else
          attributes[r][slot] = make_float4(0, 0, 0, 0);
      });
    }
    __device__ void clear(unsigned slot) {
      for_each_row([&](auto r) { attributes[r][slot] = make_float4(0, 0, 0, 0); });
    }
  };

  struct Before {
    __device__ void enter(float, std::uint32_t) {}
    __device__ void pass(float, std::uint32_t, float) {}
    __device__ bool differs(float) const { return false; }
  };

  template <unsigned pixel_count>
  struct Lane {
    float4 sums[pixel_count * rows];

    __device__ explicit Lane(const View&) {
#pragma unroll
      for (unsigned p = 0; p < pixel_count; ++p) start(p, {});
    }
    __device__ void start(unsigned p, const Before&) {
      for_each_row([&](auto r) { sums[p * rows + r] = make_float4(0, 0, 0, 0); });
    }
    __device__ void offer(unsigned, std::uint32_t, float, float) {}
    template <class Queue>
    __device__ void offer_group(const Queue&, unsigned, const float (&)[pixel_count][group_size],
                                const float (&)[pixel_count][group_size + 1]) {}
    __device__ void add(const Queued& queue, unsigned k, const float (&weights)[pixel_count]) {
      for_each_row([&](auto r) {
        const float4 row = queue.attributes[r][k];
#pragma unroll
        for (unsigned p = 0; p < pixel_count; ++p) add_scaled(sums[p * rows + r], weights[p], row);
      });
    }
    template <class Segments>
    __device__ void put(Segments&, Queued& queue, unsigned at, unsigned p, float) {
      for_each_row([&](auto r) { queue.attributes[r][at % pixels_of_warp_block] = sums[p * rows + r]; });
    }
  };

  template <unsigned count>
  struct Joined {
    float4 sums[rows][count];

    template <unsigned others>
    __device__ void copy(unsigned i, const Joined<others>& of, unsigned from) {
      for_each_row([&](auto r) { sums[r][i] = of.sums[r][from]; });
    }
    __device__ void set(unsigned i, Lane<pixels_of_lane>& lane, unsigned p, float) {
      for_each_row([&](auto r) { sums[r][i] = lane.sums[p * rows + r]; });
    }
    __device__ void join(unsigned i, Lane<pixels_of_lane>& lane, unsigned p, float, float unit) {
      for_each_row([&](auto r) { add_scaled(sums[r][i], unit, lane.sums[p * rows + r]); });
    }
    template <class AnyLane>
    __device__ Before before(unsigned, const AnyLane&, const BlendRules&) const {
      return {};
    }
    __device__ void resume(unsigned i, Lane<pixels_of_lane>& lane, unsigned p) const {
      for_each_row([&](auto r) { lane.sums[p * rows + r] = sums[r][i]; });
    }
    __device__ void end_resumed(unsigned i, Lane<pixels_of_lane>& lane, unsigned p, float left) {
      set(i, lane, p, left);
    }
    __device__ void store(unsigned i, const RasterJob& job, const View& view, std::size_t x, std::size_t y,
                          float transmittance) const {
      float plain_sums[rows * AttributeRow::channels];
      for_each_row([&](auto r) {
        const float4 row = sums[r][i];
        const float of_row[] = {row.x, row.y, row.z, row.w};
#pragma unroll
        for (unsigned c = 0; c < AttributeRow::channels; ++c)
          plain_sums[r * AttributeRow::channels + c] = multiply_rounded(of_row[c], view.rules.alpha_max);
      });
      store_attributes(view, job.attributes, x, y, transmittance, plain_sums);
    }
  };

  /// None: sums lie where those of splats were queued.
  template <unsigned count>
  struct Segments {};

  struct Channel {
    float sums[rows] = {};

    template <unsigned count>
    __device__ void load(const Joined<count>& joined, unsigned pixel, unsigned channel) {
      for_each_row([&](auto r) { sums[r] = (&joined.sums[r][pixel].x)[channel]; });
    }
    template <class Shared>
    __device__ void join(const Shared& of, unsigned at, unsigned channel, float scaled) {
      for_each_row([&](auto r) {
        const float4& sum = of.queues[at / pixels_of_warp_block].attributes[r][at % pixels_of_warp_block];
        sums[r] = fmaf(scaled, (&sum.x)[channel], sums[r]);
      });
    }
    template <unsigned count>
    __device__ void store(Joined<count>& joined, unsigned pixel, unsigned channel) const {
      for_each_row([&](auto r) { (&joined.sums[r][pixel].x)[channel] = sums[r]; });
    }
  };
};

}  // namespace swiftgs::kernels
