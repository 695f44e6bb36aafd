// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/launch.cuh>

#include "pixel.cuh"

namespace swiftgs {

namespace kernels {
inline constexpr unsigned block_threads = tile_side * tile_side;

/// The pixel of this thread, where a block blends a tile and all its threads load splats for all.
template <bool extras>
struct TilePixel {
  const RasterJob& job;
  PixelPlace place;
  Pixel pixel;
  ThreadCounts counts;
  std::uint32_t evaluated = 0;

  __device__ explicit TilePixel(const RasterJob& of)
      : job(of), place(of, left() + column(), top() + row(), extras) {
    if (place.inside) pixel.start(job.rules.stop_below);
  }

  __device__ static int column() { return int(threadIdx.x % tile_side); }
  __device__ static int row() { return int(threadIdx.x / tile_side); }
  __device__ vec2 first_centre() const { return vec2(float(left()) + 0.5f, float(top()) + 0.5f); }

  /// Whether no pixel of the tile is left that could show another splat. A barrier of the block.
  __device__ bool all_stopped() const { return __syncthreads_and(!pixel.live()) != 0; }

  __device__ void blend(float alpha, const float4& colour) {
    if constexpr (extras) ++evaluated;
    kernels::blend<extras>(pixel, alpha, colour, place.occluder, counts);
  }

  /// Writes the pixel, and the counts of a tile that visited so many instances.
  __device__ void store(std::uint32_t instances) const {
    if (place.inside)
      store_pixel(job.frame, std::size_t(place.x), std::size_t(place.y), pixel.blended(), job.background);
    if constexpr (extras)
      if (job.counts) add_counts(job.counts, blockIdx.x, counts, instances, warp_sum(evaluated));
  }

 private:
  __device__ int left() const { return int(blockIdx.x % unsigned(job.grid.columns)) * tile_side; }
  __device__ int top() const { return int(blockIdx.x / unsigned(job.grid.columns)) * tile_side; }
};
}  // namespace kernels

/// Starts `lean`, or `full` where the frame wants more than colour and alpha: a block a tile.
inline void rasterize_blocks(Cuda& cuda, const char* name, void (*lean)(RasterJob), void (*full)(RasterJob),
                             const RasterJob& job) {
  if (job.counts) cuda.clear(job.counts, job.grid.size() * sizeof(TileCounts));
  launch(name, kernels::wants_extras(job) ? full : lean, unsigned(job.grid.size()), kernels::block_threads,
         cuda.stream(), job);
}

}  // namespace swiftgs
