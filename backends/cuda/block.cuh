// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/launch.cuh>

#include "pixel.cuh"

namespace swiftgs {

namespace kernels {
inline constexpr unsigned block_threads = square_side * square_side;

/// The pixel of this thread, where a block blends a square and all its threads load splats for all.
template <bool extras>
struct SquarePixel {
  const RasterJob& job;
  const View& view;
  PixelPlace place;
  Pixel pixel;
  ThreadCounts counts;
  std::uint32_t evaluated = 0;

  __device__ SquarePixel(const RasterJob& of, const View& in)
      : job(of), view(in), place(in.frame, BlockSquare::x() + column(), BlockSquare::y() + row(), extras) {
    if (place.inside) pixel.start(view.rules.stop_below);
  }

  __device__ static int column() { return int(threadIdx.x % square_side); }
  __device__ static int row() { return int(threadIdx.x / square_side); }
  __device__ vec2 first_centre() const {
    return vec2(float(BlockSquare::x()) + 0.5f, float(BlockSquare::y()) + 0.5f);
  }

  /// Whether no pixel of the square is left that could show another splat. A barrier of the block.
  __device__ bool all_stopped() const { return __syncthreads_and(!pixel.live()) != 0; }

  __device__ void blend(float alpha, const float4& colour) {
    if constexpr (extras) ++evaluated;
    kernels::blend<extras>(pixel, alpha, colour, place.occluder, counts);
  }

  /// Writes the pixel, and the counts of a square that visited so many instances.
  __device__ void store(std::uint32_t instances) const {
    if (place.inside)
      store_pixel(view.frame, std::size_t(place.x), std::size_t(place.y), pixel.blended(), view.background);
    if constexpr (extras)
      if (job.counts) add_counts(job.counts, counts, instances, warp_sum(evaluated));
  }
};
}  // namespace kernels

/// Starts `lean`, or `full` where the frame wants more than colour and alpha: a block a square.
inline void rasterize_blocks(Cuda& cuda, const char* name, void (*lean)(RasterJob, View),
                             void (*full)(RasterJob, View), const RasterJob& job) {
  const View& view = view_of(job);
  kernels::launch_squares(cuda, name, kernels::wants_extras(job, view.frame) ? full : lean,
                          kernels::block_threads, job, view);
}

}  // namespace swiftgs
