// SPDX-License-Identifier: Apache-2.0
#include <cstdint>

#include <swiftgs/contribution.hpp>
#include <swiftgs/cuda.cuh>

#include "raster_warps.cuh"
#include "weigh.hpp"

namespace swiftgs {

namespace kernels {

/// Terms of the splats that a warp looks at together, as its part of the tile sees them.
struct WarpTerms {
  float4 terms[warp_size];
  CholeskyForm::Rest rests[warp_size];
};

/// Sum over all lanes of values below 2^48.
__device__ inline std::uint64_t wide_warp_sum(std::uint64_t value) {
  // Halves of 24 bits, so that 32 of them stay below 2^32.
  const std::uint32_t low = warp_sum(std::uint32_t(value & 0xffffff));
  return (std::uint64_t(warp_sum(std::uint32_t(value >> 24))) << 24) + low;
}

/// Adds up the weights of one tile's list: a block a tile, a warp an 8x8 part of it, a lane two pixels, with
/// the terms and the rules of `raster_warps`. A lane adds the sum of the splat that it has loaded: one atomic
/// addition for a splat and part.
__global__ void __launch_bounds__(raster_threads)
    add_contributions(const __grid_constant__ ContributionJob job,
                      const __grid_constant__ RasterLimits limits) {
  __shared__ WarpTerms shared[parts_of_tile];
  const RasterJob& raster = job.raster;
  const unsigned warp = threadIdx.x / warp_size;
  WarpTerms& mine = shared[warp];
  const std::uint32_t tile = blockIdx.x;
  const int part_x = int(tile % unsigned(raster.grid.columns)) * tile_side + int(warp % 2 * part_side);
  const int part_y = int(tile / unsigned(raster.grid.columns)) * tile_side + int(warp / 2 * part_side);
  if (part_x >= raster.frame.width || part_y >= raster.frame.height) return;
  const vec2 first_centre(float(part_x) + 0.5f, float(part_y) + 0.5f);

  const int column = int(lane_index() % part_side), row = int(lane_index() / part_side);
  Pixel pixels[pixels_of_lane];
#pragma unroll
  for (unsigned p = 0; p < pixels_of_lane; ++p)
    if (PixelPlace(raster, part_x + column, part_y + row + int(p) * int(rows_between), false).inside)
      pixels[p].start(limits.stop_below);

  const bool some_hidden = raster.colours.some_hidden();
  const TileRange range = raster.lists.ranges[tile];
  for (std::uint32_t at = range.begin; at < range.end; at += warp_size) {
    // Load a splat a lane, and find those that touch the part.
    const bool listed = at + lane_index() < range.end;
    const std::uint32_t id = listed ? raster.lists.ids[at + lane_index()] : 0;
    bool touched = false;
    if (listed) {
      const SplatShape shape = load_shape(raster, id);
      touched = box_touched(shape, first_centre, float(part_side)) &&
                !(some_hidden && is_hidden(raster.colours.each[id]));
      if (touched)
        CholeskyForm::prepare(shape, shape.mean - first_centre, limits.log2_alpha_min,
                              mine.terms[lane_index()], mine.rests[lane_index()]);
    }
    unsigned waiting = __ballot_sync(whole_warp, touched);
    __syncwarp();

    // Blend them front to back; the lane that loaded a splat keeps its sum.
    std::uint64_t sum = 0;
    for (; waiting != 0; waiting &= waiting - 1) {
      const unsigned owner = unsigned(__ffs(int(waiting))) - 1;
      float exponents[pixels_of_lane];
      CholeskyForm::evaluate(mine.terms[owner], mine.rests[owner], float(column), float(row), exponents);
      std::uint64_t parts = 0;
#pragma unroll
      for (unsigned p = 0; p < pixels_of_lane; ++p)
        parts += weight_parts(weigh(pixels[p], alpha_of<true>(exponents[p], limits)));
      if (!__any_sync(whole_warp, parts != 0)) continue;
      const std::uint64_t of_part = wide_warp_sum(parts);
      if (lane_index() == owner) sum = of_part;
    }
    if (sum != 0) {
      static_assert(sizeof(unsigned long long) == sizeof(std::uint64_t));
      atomicAdd(reinterpret_cast<unsigned long long*>(job.sums + raster.splats.gaussians[id]), sum);
    }

    bool stopped = true;
#pragma unroll
    for (unsigned p = 0; p < pixels_of_lane; ++p) stopped = stopped && !pixels[p].live();
    if (__all_sync(whole_warp, stopped)) break;
    __syncwarp();  // before the terms are overwritten
  }
}
}  // namespace kernels

void add_contributions(Cuda& cuda, const ContributionJob& job) {
  launch("add_contributions", kernels::add_contributions, unsigned(job.raster.grid.size()),
         kernels::raster_threads, cuda.stream(), job, kernels::RasterLimits(job.raster.rules));
}

template void Cuda::for_each(std::size_t, const ClearSums&) const;

}  // namespace swiftgs
