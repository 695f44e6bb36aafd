// SPDX-License-Identifier: Apache-2.0
#include <swiftgs/cuda/features.hpp>
#include <swiftgs/cuda/launch.cuh>
#include <swiftgs/raster/per_pixel.hpp>

#include "block.cuh"
#include "other_exponents.hpp"

namespace swiftgs {

namespace kernels {

/// Splats as every pixel of a raster block reads them.
struct FactorBatch {
  float2 from_means[block_threads];  ///< to the raster block's first pixel
  float4 factors[block_threads];     ///< of `FactorExponent`, with opacity 0 where the raster block does not
                                     ///< show it
  float4 colours[block_threads];     ///< RGB, depth
};

/// One thread block per raster block, one thread per pixel: the whole exponent and exponential of every
/// listed splat, as gsplat has it.
template <bool planes, class ViewSource>
__global__ void __launch_bounds__(block_threads, resident_blocks(planes ? 6 : 8, block_threads))
    raster_per_pixel(const __grid_constant__ RasterInput<ViewSource> input) {
  __shared__ FactorBatch batch;
  const RasterJob& job = input.job;
  RasterBlockPixel<planes, planes, ViewSource> mine(input);
  if (mine.raster_block.outside(input)) return;
  const TileRange range = mine.raster_block.list(input);
  if (!range.drawn()) return;
  const float x = float(mine.column()), y = float(mine.row());

  for (std::uint32_t at = range.begin; at < range.end && !mine.all_stopped(); at += block_threads) {
    std::uint32_t count = min(range.end - at, block_threads);
    asm volatile("" : "+r"(count));  // the compiler would find the minimum again for each splat
    if (threadIdx.x < count) {
      const std::uint32_t id = job.lists.ids[at + threadIdx.x];
      const SplatShape s = load_shape(job.splats, id);
      const vec2 from_mean = s.from_mean(mine.first_centre());
      batch.from_means[threadIdx.x] = make_float2(from_mean.x, from_mean.y);
      const float4 colour = load_colour(job, id);
      float4 factor = FactorExponent::prepare(s);
      if (!box_touched(s, mine.first_centre(), raster_block_side) || is_colourless(colour)) factor.w = 0;
      batch.factors[threadIdx.x] = factor;
      batch.colours[threadIdx.x] = colour;
    }
    __syncthreads();
    for (std::uint32_t k = 0; k < count && mine.pixel.live(); ++k) {
      const float2 from_mean = batch.from_means[k];
      const float4 factor = batch.factors[k];
      const float dx = x + from_mean.x, dy = y + from_mean.y;
      mine.blend(FactorExponent::alpha(factor, dx, dy, mine.view().rules), batch.colours[k], at + k);
    }
  }
  mine.store();
}

struct PerPixelKernel {
  static constexpr unsigned threads = block_threads;
  template <bool planes, class ViewSource>
  static constexpr auto of = &raster_per_pixel<planes, ViewSource>;
};
}  // namespace kernels

void rasterize(Cuda& cuda, PerPixel, const RasterJob& job) {
  kernels::launch_raster_blocks<kernels::PerPixelKernel>(cuda, "rasterize per-pixel", job,
                                                         kernels::asks_for_planes(job));
}

}  // namespace swiftgs
