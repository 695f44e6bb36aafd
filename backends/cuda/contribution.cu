// SPDX-License-Identifier: Apache-2.0
#include <cstdint>

#include <swiftgs/contribution.hpp>
#include <swiftgs/cuda/features.hpp>
#include <swiftgs/cuda/launch.cuh>

#include "lane_blender.cuh"
#include "weigh.hpp"

namespace swiftgs {

namespace kernels {

/// Exponents and Gaussians of queued splats.
struct IdQueue : TermsQueue<CholeskyExponent> {
  std::uint32_t gaussians[queue_size];
};

/// Sum over all lanes of values below 2^48.
__device__ inline std::uint64_t wide_warp_sum(std::uint64_t value) {
  // Halves of 24 bits, so that 32 of them stay below 2^32.
  const std::uint32_t low = warp_sum(std::uint32_t(value & 0xffffff));
  return (std::uint64_t(warp_sum(std::uint32_t(value >> 24))) << 24) + low;
}

/// Blends as `ColourBlender` does, but each list in one segment, and adds up weights: one atomic addition per
/// splat and warp block.
struct WeightBlender {
  static constexpr bool in_segments = false;
  const RasterJob& job;
  std::uint64_t* sums;
  const BlendRules& rules;
  IdQueue& queue;
  float x, y;  ///< of the lane's first pixel within the warp block
  Pixel pixels[pixels_of_lane];

  __device__ void fill(unsigned slot, std::uint32_t id) const {
    queue.gaussians[slot] = job.splats.gaussians[id];
  }

  __device__ void await_queued() const { __syncwarp(); }

  /// Blends up to 32 splats from `first` on. Lane k keeps the sum of the k-th.
  __device__ void blend_queued(unsigned first, unsigned count) {
    static_assert(queue_half == warp_size);
    std::uint64_t sum = 0;
    for (unsigned k = 0; k < count; ++k) {
      float exponents[pixels_of_lane];
      CholeskyExponent::evaluate(queue.terms[first + k], queue.rests[first + k], x, y, exponents);
      std::uint64_t parts = 0;
#pragma unroll
      for (unsigned p = 0; p < pixels_of_lane; ++p)
        parts += weight_parts(weigh(pixels[p], relative_alpha<true>(exponents[p], rules), rules.alpha_max));
      if (!__any_sync(whole_warp, parts != 0)) continue;
      const std::uint64_t of_warp_block = wide_warp_sum(parts);
      if (lane_index() == k) sum = of_warp_block;
    }
    if (sum != 0) {
      static_assert(sizeof(unsigned long long) == sizeof(std::uint64_t));
      atomicAdd(reinterpret_cast<unsigned long long*>(sums + queue.gaussians[first + lane_index()]), sum);
    }
    __syncwarp();  // before the queue is overwritten
  }

  __device__ bool all_stopped() const { return kernels::all_stopped(pixels); }
};

/// Adds up the weights of one raster block's list: one thread block per raster block, one warp per 8x8 warp
/// block of it.
template <class ViewSource>
__global__ void __launch_bounds__(raster_threads)
    add_contributions(const __grid_constant__ RasterInput<ViewSource> input, std::uint64_t* sums) {
  __shared__ IdQueue queues[warps_of_raster_block];
  IdQueue& queue = queues[threadIdx.x / warp_size];
  const OwnRasterBlock raster_block(input);
  const View& view = input.views[raster_block.view];
  const BlendRules rules = view.rules;
  const WarpBlock warp_block(raster_block, threadIdx.x / warp_size);
  if (warp_block.outside(view.frame)) return;

  WeightBlender blender{input.job, sums, rules, queue, float(warp_block.column), float(warp_block.row), {}};
#pragma unroll
  for (unsigned p = 0; p < pixels_of_lane; ++p)
    if (warp_block.pixel(view.frame, p, false).inside) blender.pixels[p].start(rules.stop_below);

  const TileRange range = raster_block.list(input);
  ListTraversal<CholeskyExponent> traversal(input.job, range, warp_block.first_centre(view), rules, queue);
  traversal.go_on(blender, range.end);
  traversal.blend_rest(blender);
}
}  // namespace kernels

void add_contributions(Cuda& cuda, const ContributionJob& job) {
  const RasterBlocks raster_blocks = raster_blocks_of(job.raster);
  kernels::with_views(job.raster.views, [&]<class ViewSource>(const ViewSource& views) {
    launch("add_contributions", kernels::add_contributions<ViewSource>, kernels::blocks_of(raster_blocks),
           kernels::raster_threads, cuda.stream(),
           kernels::RasterInput<ViewSource>{job.raster, views, raster_blocks, nullptr}, job.sums);
  });
}

template void Cuda::for_each(Count, const ClearSums&) const;

}  // namespace swiftgs
