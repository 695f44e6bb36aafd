// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdint>

#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/launch.cuh>
#include <swiftgs/cuda/view_source.cuh>
#include <swiftgs/cuda/warp.cuh>
#include <swiftgs/hidden_stage.hpp>

namespace swiftgs {

namespace kernels {
inline constexpr unsigned hidden_threads = 256, hidden_warps = hidden_threads / warp_size;

/// One thread block per tile. All threads find the farthest depth, and one searches the list for it.
template <class ViewSource>
__global__ void __launch_bounds__(hidden_threads)
    count_hidden(const __grid_constant__ RasterJob job, const __grid_constant__ ViewSource views,
                 std::uint32_t* to) {
  __shared__ float of_warps[hidden_warps];
  const std::uint32_t tile = blockIdx.x;
  std::uint32_t index = 0;
  if constexpr (!ViewSource::only) index = view_of_tile(views.views, views.count, tile);
  const PlacedTile place(views[index], tile);
  const bool counts = place.view.frame.occluder.data && place.columns > 0;
  float farthest = -INFINITY;
  if (counts)
    for (int i = int(threadIdx.x); i < place.columns * place.rows; i += int(hidden_threads))
      farthest = fmaxf(farthest, place.hidden_from(i));
  for (unsigned step = warp_size / 2; step > 0; step /= 2)
    farthest = fmaxf(farthest, __shfl_xor_sync(whole_warp, farthest, step));
  if (lane_index() == 0) of_warps[threadIdx.x / warp_size] = farthest;
  __syncthreads();
  if (threadIdx.x != 0) return;
  for (const float of_warp : of_warps) farthest = fmaxf(farthest, of_warp);
  to[tile] = counts ? count_from(job, job.lists.ranges[tile], farthest) : 0;
}
}  // namespace kernels

void count_hidden(Cuda& cuda, const RasterJob& job, std::uint32_t* to) {
  kernels::with_views(job.views, [&]<class ViewSource>(const ViewSource& views) {
    launch("count_hidden", kernels::count_hidden<ViewSource>, unsigned(job.views.tiles.size()),
           kernels::hidden_threads, cuda.stream(), job, views, to);
  });
}

}  // namespace swiftgs
