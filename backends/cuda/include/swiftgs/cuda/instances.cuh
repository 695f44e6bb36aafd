// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/for_each.cuh>
#include <swiftgs/cuda/rows.cuh>
#include <swiftgs/cuda/running_sum.cuh>

namespace swiftgs {

namespace kernels {
inline constexpr unsigned emit_threads = 256;
inline constexpr unsigned emit_warps = emit_threads / warp_size;

/// Where instances are written to.
template <class Key>
struct Instances {
  Key* keys;
  std::uint32_t* ids;
  std::uint32_t count;
};

/// Key of a splat in a tile: the tile, in 64 bits above the depth.
template <class Key>
__device__ Key instance_key(std::uint32_t tile, std::uint32_t depth) {
  if constexpr (sizeof(Key) == 8)
    return Key(tile) << depth_key_bits | depth;
  else
    return Key(tile);
}

/// Writes one pair for each tile of the splats of a block, after those of the blocks before it. A warp writes the
/// instances of its 32 splats together: neighbouring lanes write neighbouring words, however unlike the splats are.
template <class Bounds, class Key>
__global__ void __launch_bounds__(emit_threads)
    emit_instances(const __grid_constant__ SortJob job, const Bounds bounds, const std::uint32_t* order,
                   const Instances<Key> out, const RunningSums::View sums) {
  __shared__ std::uint32_t place_of_block, before_block, tiles_of[emit_warps];
  __shared__ SharedArray<SplatShape, warp_size> shapes_of[emit_warps];
  const unsigned warp = threadIdx.x / warp_size;
  SplatShape* shapes = shapes_of[warp].data();
  RunningSum sum(sums);
  if (threadIdx.x == 0) place_of_block = sum.take_place(gridDim.x);
  __syncthreads();
  const std::uint32_t place = place_of_block;

  // Load a splat a lane.
  const std::size_t i = std::size_t(place) * emit_threads + threadIdx.x;
  const bool mine = i < job.splats.size();
  const std::uint32_t id = !mine ? 0 : order ? order[i] : std::uint32_t(i);
  std::uint32_t tiles = 0, depth = 0;
  TileRect rect;
  if (mine) {
    tiles = job.splats.tiles[id];
    if constexpr (sizeof(Key) == 8) depth = depth_key(job.splats.colours[id].depth);
    const SplatShape shape = job.splats.shapes[id];
    shapes[lane_index()] = shape;
    rect = bounds.rect(shape, job.grid);
  }
  const std::uint32_t tiles_below = sum_below(tiles);
  if (lane_index() == warp_size - 1) tiles_of[warp] = tiles_below + tiles;
  __syncthreads();

  // Find where the block's instances begin, and in them the warp's.
  if (warp == 0) {
    std::uint32_t all = 0;
    for (unsigned w = 0; w < emit_warps; ++w) all += tiles_of[w];
    if (lane_index() == 0) sum.add(place, all);
    const std::uint32_t before = sum.before(place, all);
    if (lane_index() == 0) before_block = before;
  }
  __syncthreads();
  std::uint32_t at = before_block;
  for (unsigned w = 0; w < warp; ++w) at += tiles_of[w];
  const std::uint32_t end = min(at + tiles_of[warp], out.count);

  // Emit 32 rows of tiles at a time.
  for_each_row(bounds, shapes, rect, [&](unsigned owner, int row, TileRun run) {
    const std::uint32_t size = std::uint32_t(run.size()), first = sum_below(size);
    const std::uint32_t total = __shfl_sync(whole_warp, first + size, warp_size - 1);
    const int tile_of_run = row * job.grid.columns + run.begin;
    const std::uint32_t their_id = __shfl_sync(whole_warp, id, int(owner));
    const std::uint32_t their_depth = sizeof(Key) == 8 ? __shfl_sync(whole_warp, depth, int(owner)) : 0;
    for (std::uint32_t begin = 0; begin < total; begin += warp_size) {
      const std::uint32_t position = begin + lane_index();
      const int lane = int(owner_of(position, first));
      const std::uint32_t tile = std::uint32_t(__shfl_sync(whole_warp, tile_of_run, lane)) + position -
          __shfl_sync(whole_warp, first, lane);
      const std::uint32_t its_depth = sizeof(Key) == 8 ? __shfl_sync(whole_warp, their_depth, lane) : 0;
      const std::uint32_t its_id = __shfl_sync(whole_warp, their_id, lane);
      if (position < total && at + position < end) {
        out.keys[at + position] = instance_key<Key>(tile, its_depth);
        out.ids[at + position] = its_id;
      }
    }
    at += total;
  });
}
}  // namespace kernels

template <BoundsPolicy Bounds, class Key>
std::size_t emit_instances(Cuda& cuda, const SortJob& job, const Bounds& bounds, const std::uint32_t* order,
                           InstanceScratch<Cuda>& scratch, Pairs<Cuda, Key>& instances) {
  const std::size_t splats = job.splats.size();
  SortJob counted = job;
  if (!job.splats.tiles.data && splats != 0) {
    // Count here what projection did not. The sum of a copy is what is needed, and the counts themselves.
    scratch.tiles.reset(2 * splats);
    std::uint32_t* const tiles = scratch.tiles.data();
    for (std::uint32_t* to : {tiles, tiles + splats})
      cuda.for_each(splats, CountTiles<Bounds>{job.splats, nullptr, job.grid, bounds, to});
    counted.splats.tiles = {tiles, splats};
    counted.splats.instances = cuda.exclusive_scan(Span{tiles + splats, splats});
  }
  const std::uint64_t total = counted.splats.instances;
  check_instances(total);
  instances.reset(std::size_t(total));
  if (total == 0) return 0;
  const unsigned blocks = blocks_for(splats, kernels::emit_threads);
  launch("emit_instances", kernels::emit_instances<Bounds, Key>, blocks, kernels::emit_threads, cuda.stream(),
         counted, bounds, order,
         kernels::Instances<Key>{instances.keys.data(), instances.values.data(), std::uint32_t(total)},
         scratch.sums.next(cuda, blocks));
  return std::size_t(total);
}

}  // namespace swiftgs
