// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>

#include <swiftgs/cuda/features.hpp>
#include <swiftgs/cuda/launch.cuh>
#include <swiftgs/cuda/raster_block.cuh>
#include <swiftgs/cuda/warp.cuh>
#include <swiftgs/drivers/pick.hpp>

#include "exponents.hpp"

namespace swiftgs {

namespace kernels {
/// A thread block picks at pixels of a row that one raster block holds, a warp at each.
inline constexpr unsigned pick_threads = 256, pick_warps = pick_threads / warp_size;
inline constexpr int pixels_of_pick = int(pick_warps);
static_assert(raster_block_side % pixels_of_pick == 0);

/// Splats that are tested together.
struct PickBatch {
  float alphas[pick_warps][pick_threads];  ///< at each pixel
  unsigned shown[pick_warps][pick_warps];  ///< of each pixel, a bit for each splat that it shows
  bool live[pick_warps];                   ///< pixels that later splats may change
  float depths[pick_threads];
  std::uint32_t gaussians[pick_threads];
};

/// Threads evaluate alphas of as many splats at all pixels. Then each warp takes those of its pixel front to
/// back.
__global__ void __launch_bounds__(pick_threads) pick_pixels(const __grid_constant__ PickJob job) {
  __shared__ PickBatch batch;
  const unsigned warp = threadIdx.x / warp_size;
  const int y = job.y + int(blockIdx.y),
            first_x = (job.x / pixels_of_pick + int(blockIdx.x)) * pixels_of_pick;
  const int x = first_x + int(warp);
  const bool wanted = x >= job.x && x < job.x + job.width;
  const vec2 centre = job.centre(first_x, y), first_centre = job.first_centre(first_x, y);
  const BlendRules& rules = job.view.rules;
  PixelPicker picker(rules.stop_below);
  const TileRange range = job.list(first_x, y);
  bool goes_on = wanted && range.drawn();
  for (std::uint32_t first = range.begin;; first += pick_threads) {
    goes_on = goes_on && first < range.end;
    if (lane_index() == 0) batch.live[warp] = goes_on;
    if (!__syncthreads_or(goes_on)) break;  // also before the batch is overwritten
    SplatShape shape;
    bool touched = false;
    if (first + threadIdx.x < range.end) {
      const std::uint32_t id = job.lists.ids[first + threadIdx.x];
      const float depth = job.colours[id].depth;  // 0 of colourless splats
      shape = load_shape(job.splats, id);
      touched = depth > 0 && box_touched(shape, first_centre, float(raster_block_side));
      batch.depths[threadIdx.x] = depth, batch.gaussians[threadIdx.x] = job.splats.gaussians[id];
    }
    for (unsigned p = 0; p < pick_warps; ++p) {
      if (!batch.live[p]) continue;
      const float alpha = touched ? alpha_at(shape, vec2(centre.x + float(p), centre.y), rules) : 0.0f;
      batch.alphas[p][threadIdx.x] = alpha;
      const unsigned shown = __ballot_sync(whole_warp, alpha > 0);
      if (lane_index() == 0) batch.shown[p][warp] = shown;
    }
    __syncthreads();
    for (unsigned w = 0; w < pick_warps && goes_on; ++w)
      for (unsigned left = batch.shown[warp][w]; left != 0 && goes_on; left &= left - 1) {
        const unsigned k = w * warp_size + unsigned(__ffs(int(left))) - 1;
        goes_on = picker.offer(batch.alphas[warp][k], batch.depths[k], batch.gaussians[k]);
      }
  }
  if (wanted && lane_index() == 0) job.to[blockIdx.y * job.pitch + std::size_t(x - job.x)] = picker.picked();
}
}  // namespace kernels

void pick_pixels(Cuda& cuda, const PickJob& job) {
  const int blocks = (job.x + job.width - 1) / kernels::pixels_of_pick - job.x / kernels::pixels_of_pick + 1;
  launch("pick_pixels", kernels::pick_pixels, dim3(unsigned(blocks), unsigned(job.height)),
         kernels::pick_threads, cuda.stream(), job);
}

}  // namespace swiftgs
