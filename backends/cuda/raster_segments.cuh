// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

#include "raster_warps.cuh"
#include "segment_rounds.cuh"

namespace swiftgs::kernels {

/// The helper kernel. It blends work items that `raster_warps` pushes, while that kernel still runs, in
/// thread blocks that fit beside it. Clusters blend the longest items, single thread blocks the rest.
template <class Exponent, bool threshold, class Planes, class ViewSource>
__global__ void __launch_bounds__(segment_threads, segment_occupancy<Planes>)
    raster_segments(const __grid_constant__ RasterInput<ViewSource> input,
                    const __grid_constant__ WorkQueues work_queues) {
  extern __shared__ __align__(16) std::byte memory[];
  auto& shared = *reinterpret_cast<SegmentShared<Exponent, Planes>*>(memory);
  const Group cluster = Group::cluster();
  // Odd clusters take items for clusters first, even ones take items for single thread blocks first.
  bool as_cluster = cluster.blocks != 1 && blockIdx.x / cluster.blocks % 2 == 1;
  if (threadIdx.x == 0 && !(as_cluster && cluster.rank != 0)) work_queues.begin(as_cluster);
  for (unsigned kind = 0; kind < (cluster.blocks == 1 ? 1 : 2); ++kind, as_cluster = !as_cluster) {
    const Group group = as_cluster ? cluster : Group();
    for (;;) {
      group.sync();
      if (group.rank == 0 && threadIdx.x == 0) {
        const WorkItem* const next = work_queues.await_next(as_cluster);
        for (unsigned b = 0; b < group.blocks; ++b) group.in(b, shared).item = next;
      }
      group.sync();
      const WorkItem* const item = shared.item;
      if (!item) break;
      using ItemPlanes = typename Planes::template Joined<pixels_of_warp_block>;
      WorkItemBlender<Exponent, threshold, Planes, ViewSource>(input, *item, group, shared)
          .run(*item, work_queues.planes_of<const ItemPlanes>(item));
      if (group.rank == 0 && threadIdx.x == 0) work_queues.end_item(as_cluster);
    }
  }
  if (threadIdx.x == 0) work_queues.leave();
}

/// Rasterizes `Planes` with `Exponent` in registers.
template <class Exponent, bool threshold, class Planes>
void rasterize_warps(Cuda& cuda, const char* name, const RasterJob& job) {
  with_raster_input(cuda, job, [&]<class ViewSource>(const RasterInput<ViewSource>& input) {
    using Shared = SegmentShared<Exponent, Planes>;
    const WorkQueues work_queues = WorkQueues::of<typename Planes::template Joined<pixels_of_warp_block>>(
        cuda, input.raster_blocks.size() * warps_of_raster_block);
    const bool shared = WorkQueues::are_shared(cuda) && sizeof(Shared) <= cuda.shared_memory();
    auto warps = raster_warps<Exponent, threshold, Planes, true, ViewSource>;
    if constexpr (Planes::few)
      if (!shared) warps = raster_warps<Exponent, threshold, Planes, false, ViewSource>;
    launch(name, warps, blocks_of(input.raster_blocks), raster_threads, cuda.stream(), input,
           shared ? work_queues : work_queues.closed());
    if (!shared) return;
    const auto segments = raster_segments<Exponent, threshold, Planes, ViewSource>;
    const BlockShape block(segment_threads, sizeof(Shared));
    const unsigned clusters = unsigned(cuda.multiprocessors()) * blocks_of_multiprocessor / blocks_of_group;
    try {
      allow_shared(segments, block);
      launch_early<blocks_of_group>(cuda, name, segments, std::max(clusters, 1u) * blocks_of_group, block,
                                    input, work_queues);
    } catch (const DeviceError&) {
      work_queues.forget(cuda);  // the next frame must not blend items of this one
      throw;
    }
  });
}

/// Rasterizes colour and alpha, and depth if a view has to sum depths or to hide splats by them.
template <class Exponent, bool threshold>
void rasterize_colour(Cuda& cuda, const char* name, const RasterJob& job) {
  if (some_view_has_depth(job))
    rasterize_warps<Exponent, threshold, PixelPlanes<Depths::of_means>>(cuda, name, job);
  else
    rasterize_warps<Exponent, threshold, PixelPlanes<Depths::none>>(cuda, name, job);
}

}  // namespace swiftgs::kernels
