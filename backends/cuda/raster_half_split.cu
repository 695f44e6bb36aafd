// SPDX-License-Identifier: Apache-2.0
#include <cuda_fp16.h>

#include <swiftgs/cuda/features.hpp>

#include "block.cuh"
#include "planes.hpp"

namespace swiftgs {

namespace kernels {

/// Splats whose shared terms are computed together (SwiftGS, section 5.1): eight, so that the first eight
/// rows of threads have one x term each, and the other eight one y term each.
inline constexpr unsigned mini_batch = 8;

/// Terms that the pixels of a raster block share. Two mini-batches alternate: one is computed while slower
/// warps still read the other. A warp reads sixteen neighbouring words of x and two of y, without bank
/// conflicts.
struct HalfBatch {
  SharedArray<SplatShape, block_threads> shapes;
  float4 colours[block_threads];  ///< RGB, depth
  float2 cutoffs[block_threads];  ///< largest s that is kept, log2(255 opacity) in the paper; and opacity
  __half2 x[2][mini_batch][raster_block_side];  ///< a dx^2, b dx
  __half2 y[2][mini_batch][raster_block_side];  ///< c dy^2, dy
};

/// This thread's term of a mini-batch that begins with splat `first`, of `count` in the batch. Where there is
/// no splat, or it does not touch the row, no pixel keeps it.
__device__ inline void compute_term(HalfBatch& batch, unsigned buffer, unsigned first, unsigned count,
                                    vec2 first_centre) {
  const unsigned splat = threadIdx.x / raster_block_side % mini_batch,
                 position = threadIdx.x % raster_block_side;
  const SplatShape& s = batch.shapes.data()[first + splat];
  const detail::MeanSplit terms(s);
  if (threadIdx.x < mini_batch * raster_block_side) {
    const vec2 term = terms.x_term(first_centre.x + float(position));
    batch.x[buffer][splat][position] = __floats2half2_rn(term.x, term.y);
  } else {
    const float y = first_centre.y + float(position);
    const vec2 term = terms.y_term(y);
    const bool touched = first + splat < count && row_touched(s, first_centre.x, y);
    batch.y[buffer][splat][position] = __floats2half2_rn(touched ? term.x : INFINITY, term.y);
  }
}

/// One thread block per raster block, one thread per pixel. Each mini-batch has its terms computed by all
/// threads, and is then blended by all.
template <bool threshold, bool depth, class ViewSource>
__global__ void __launch_bounds__(block_threads)
    raster_half_split(const __grid_constant__ RasterInput<ViewSource> input) {
  __shared__ HalfBatch batch;
  const RasterJob& job = input.job;
  RasterBlockPixel<depth, false, ViewSource> mine(input);
  if (mine.raster_block.outside(input)) return;
  const TileRange range = mine.raster_block.list(input);
  if (!range.drawn()) return;
  const unsigned column = threadIdx.x % raster_block_side, row = threadIdx.x / raster_block_side;

  for (std::uint32_t at = range.begin; at < range.end && !mine.all_stopped(); at += block_threads) {
    const std::uint32_t count = min(range.end - at, block_threads);
    if (threadIdx.x < count) {
      const std::uint32_t id = job.lists.ids[at + threadIdx.x];
      const SplatShape s = load_shape(job.splats, id);
      batch.shapes.data()[threadIdx.x] = s;
      const float4 colour = load_colour(job, id);
      batch.cutoffs[threadIdx.x] =
          is_colourless(colour) ? make_float2(-1, 0) : make_float2(s.cutoff, s.opacity);
      batch.colours[threadIdx.x] = colour;
    } else {
      batch.cutoffs[threadIdx.x] = make_float2(-1, 0);
    }
    __syncthreads();

    for (std::uint32_t first = 0; first < count; first += mini_batch) {
      const unsigned buffer = first / mini_batch % 2;
      compute_term(batch, buffer, first, count, mine.first_centre());
      __syncthreads();
      if (!mine.pixel.live()) continue;

#pragma unroll
      for (unsigned k = 0; k < mini_batch; ++k) {
        const float2 x = __half22float2(batch.x[buffer][k][column]),
                     y = __half22float2(batch.y[buffer][k][row]);
        const float s = x.x + y.x + x.y * y.y;
        const float2 cutoff = batch.cutoffs[first + k];
        const float alpha = alpha_of_square<threshold>(s, cutoff.x, cutoff.y, mine.view().rules);
        if (alpha > 0) mine.blend(alpha, batch.colours[first + k], at + first + k);
      }
    }
  }
  mine.store();
}

template <bool threshold>
struct HalfSplitKernel {
  static constexpr unsigned threads = block_threads;
  template <bool depth, class ViewSource>
  static constexpr auto of = &raster_half_split<threshold, depth, ViewSource>;
};

template <bool threshold>
void rasterize_half(Cuda& cuda, const char* name, const RasterJob& job) {
  rasterize_few<threshold>(cuda, name, job, [&](const RasterJob& few) {
    launch_raster_blocks<HalfSplitKernel<threshold>>(cuda, name, few, some_view_has_depth(few));
  });
}
}  // namespace kernels

void rasterize(Cuda& cuda, AxisShared<HalfSplit>, const RasterJob& job) {
  kernels::rasterize_half<false>(cuda, "rasterize axis-shared-half-split", job);
}
void rasterize(Cuda& cuda, AxisSharedThreshold<HalfSplit>, const RasterJob& job) {
  kernels::rasterize_half<true>(cuda, "rasterize axis-shared-threshold-half-split", job);
}

}  // namespace swiftgs
