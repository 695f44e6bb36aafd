// SPDX-License-Identifier: Apache-2.0
#include <cstdint>

#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/launch.cuh>
#include <swiftgs/cuda/warp.cuh>
#include <swiftgs/pick.hpp>

#include "box_touched.hpp"
#include "pixel.cuh"

namespace swiftgs {

namespace kernels {
inline constexpr unsigned pick_threads = 256;

/// Splats that are tested together.
struct PickBatch {
  float alphas[pick_threads], depths[pick_threads];
  std::uint32_t gaussians[pick_threads];
  unsigned shown[pick_threads / warp_size];  ///< a bit for each splat that the pixel shows
};

/// One thread block per pixel: threads evaluate alphas of as many splats, which every thread then takes
/// front to back.
__global__ void __launch_bounds__(pick_threads) pick_pixels(const __grid_constant__ PickJob job) {
  __shared__ PickBatch batch;
  const int x = job.x + int(blockIdx.x), y = job.y + int(blockIdx.y);
  const vec2 centre = job.centre(x, y), first_centre = job.first_centre(x, y);
  const BlendRules& rules = job.view.rules;
  PixelPicker picker(rules.stop_below, job.occluder(x, y));
  const TileRange range = job.list(x, y);
  bool goes_on = range.drawn();
  for (std::uint32_t first = range.begin; goes_on && first < range.end; first += pick_threads) {
    const std::uint32_t at = first + threadIdx.x;
    float alpha = 0;
    if (at < range.end) {
      const std::uint32_t id = job.lists.ids[at];
      const float depth = job.colours[id].depth;  // 0 of hidden splats
      const SplatShape shape = load_shape(job.splats, id);
      if (depth > 0 && box_touched(shape, first_centre, float(raster_block_side)))
        alpha = alpha_at(shape, centre, rules);
      batch.alphas[threadIdx.x] = alpha, batch.depths[threadIdx.x] = depth;
      batch.gaussians[threadIdx.x] = job.splats.gaussians[id];
    }
    const unsigned shown = __ballot_sync(whole_warp, alpha > 0);
    if (lane_index() == 0) batch.shown[threadIdx.x / warp_size] = shown;
    __syncthreads();
    for (unsigned warp = 0; warp < pick_threads / warp_size && goes_on; ++warp)
      for (unsigned left = batch.shown[warp]; left != 0 && goes_on; left &= left - 1) {
        const unsigned k = warp * warp_size + unsigned(__ffs(int(left))) - 1;
        goes_on = picker.offer(batch.alphas[k], batch.depths[k], batch.gaussians[k]);
      }
    __syncthreads();  // before the batch is overwritten
  }
  if (threadIdx.x == 0) job.to[blockIdx.y * job.pitch + blockIdx.x] = picker.picked();
}
}  // namespace kernels

void pick_pixels(Cuda& cuda, const PickJob& job) {
  launch("pick_pixels", kernels::pick_pixels, dim3(unsigned(job.width), unsigned(job.height)),
         kernels::pick_threads, cuda.stream(), job);
}

}  // namespace swiftgs
