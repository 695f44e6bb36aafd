// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <swiftgs/cuda/find_bit.hpp>
#include <swiftgs/cuda/footprints.cuh>
#include <swiftgs/cuda/launch.cuh>
#include <swiftgs/cuda/running_sum.cuh>
#include <swiftgs/cuda/stages.hpp>
#include <swiftgs/cuda/view_source.cuh>
#include <swiftgs/frame/learnt.hpp>

namespace swiftgs::kernels {

inline constexpr unsigned emit_threads = 256;
inline constexpr unsigned emit_warps = emit_threads / warp_size;
/// Enough to fill a device; they share the splats.
inline constexpr unsigned emit_large_blocks = 512;

/// Where intersections are written to.
template <class Key>
struct Intersections {
  Key* keys;
  std::uint32_t* ids;
  std::uint32_t count;

  /// The tile, in 64-bit keys above the depth.
  __device__ void write(std::uint32_t at, std::uint32_t tile, std::uint32_t depth, std::uint32_t id) const {
    if (at >= count) return;
    if constexpr (sizeof(Key) == 8)
      keys[at] = Key(tile) << depth_key_bits | depth;
    else
      keys[at] = Key(tile);
    ids[at] = id;
  }
};

/// The splat of another lane.
__device__ inline EmittedSplat of_lane(const EmittedSplat& splat, unsigned lane) {
  const auto get = [&](auto value) { return __shfl_sync(whole_warp, value, int(lane)); };
  const Footprint& f = splat.footprint;
  return {get(splat.id), get(splat.depth), get(splat.at), {get(f.mask), get(f.count), get(f.first)}};
}

/// Emits the splats of a warp whose footprints have masks: an intersection a lane.
template <class Key>
__device__ void emit_masks(const EmittedSplat& mine, std::uint32_t stride, const Intersections<Key>& out) {
  const std::uint32_t count = mine.footprint.mask ? mine.footprint.count : 0, first = sum_below(count);
  const std::uint32_t total = __shfl_sync(whole_warp, first + count, warp_size - 1);
  for (std::uint32_t begin = 0; begin < total; begin += warp_size) {
    const std::uint32_t position = begin + lane_index();
    const unsigned owner = owner_of(position, first);
    const EmittedSplat splat = of_lane(mine, owner);
    const std::uint32_t nth = position - __shfl_sync(whole_warp, first, int(owner));
    if (position >= total) continue;
    const unsigned bit = find_bit(splat.footprint.mask, nth);
    const std::uint32_t tile = splat.footprint.first + bit / Footprint::side * stride + bit % Footprint::side;
    out.write(splat.at + nth, tile, splat.depth, splat.id);
  }
}

/// Splats too large for a mask, which a second kernel emits: near the camera, and in depth order next to each
/// other, they would keep a few warps busy long after all others.
/// Measured on an H200 when chosen: emission of garden takes 62 us if the warp of a large splat emits it, and
/// 37 with a second kernel, 27 and 10.
struct LargeSplats {
  const EmittedSplat* splats;
  LastCounters<std::uint32_t> counts;
};

/// Writes one pair for each tile of a thread block's splats, after those of the blocks before it. A warp
/// writes the intersections of its 32 splats together, so neighbouring lanes write neighbouring words. Thread
/// blocks without a splat return, but for the first.
template <class Key>
__global__ void __launch_bounds__(emit_threads)
    emit_intersections(const Footprint* footprints, const Count splats, const float* depths,
                       const std::uint32_t stride, const std::uint32_t* order, const Intersections<Key> out,
                       EmittedSplat* large, const EpochsView<std::uint32_t> epochs) {
  await_earlier();
  // Aligned apart, or loads of `tiles_of` would read neighbouring words while another thread writes them.
  __shared__ alignas(16) std::uint32_t tiles_of[emit_warps];
  __shared__ std::uint32_t before_block, epoch_of_block;
  const unsigned warp = threadIdx.x / warp_size;
  const std::uint32_t loaded_epoch = threadIdx.x == 0 ? read_epoch(epochs) : 0;
  const std::uint32_t n = std::uint32_t(splats.get()),
                      blocks = max((n + emit_threads - 1) / emit_threads, 1u);
  if (blockIdx.x >= blocks) return;

  // Load a splat a lane.
  // Four splats a lane save blocks and look-backs, and take longer. Measured on an H200 when chosen: the sort
  // of herz takes 255 us with four and 216 with one.
  const std::uint32_t i = blockIdx.x * emit_threads + threadIdx.x;
  EmittedSplat mine;
  if (i < n) {
    mine.id = order ? order[i] : i;
    mine.footprint = footprints[mine.id];
    if constexpr (sizeof(Key) == 8) mine.depth = depth_key(depths[mine.id]);
  }
  mine.at = sum_below(mine.footprint.count);
  if (lane_index() == warp_size - 1) tiles_of[warp] = mine.at + mine.footprint.count;
  if (threadIdx.x == 0) epoch_of_block = loaded_epoch;
  __syncthreads();

  // Find where the block's intersections begin, and in them the warp's.
  if (warp == 0) {
    std::uint32_t all = 0;
    for (unsigned w = 0; w < emit_warps; ++w) all += tiles_of[w];
    const RunningSum sum(epochs.words, epoch_of_block);
    if (lane_index() == 0) sum.add(all);
    const std::uint32_t before = sum.before(all);
    if (lane_index() == 0) {
      before_block = before;
      if (blockIdx.x == 0) epochs.next_copy(epoch_of_block) = 0;
      if (blockIdx.x + 1 == blocks) end_epoch(epochs, epoch_of_block, blocks);
    }
  }
  __syncthreads();
  mine.at += before_block;
  for (unsigned w = 0; w < warp; ++w) mine.at += tiles_of[w];

  emit_masks(mine, stride, out);
  if (mine.footprint.mask == 0 && mine.footprint.count != 0)
    large[atomicAdd(&epochs.copy(epoch_of_block), 1u)] = mine;
}

/// Warps that share a splat of more than `shared_from` tiles; smaller ones are one warp's.
inline constexpr unsigned warps_of_splat = 4;
inline constexpr std::uint32_t shared_from = 256;

/// Writes intersections `at` to `end` of a splat, in tiles outside of its bounds. For one thread.
template <class Bounds, class Key>
__device__ __noinline__ void emit_outside(const Bounds bounds, const SplatShape shape, const TileGrid& grid,
                                          const EmittedSplat splat, std::uint32_t at, std::uint32_t end,
                                          const Intersections<Key> out) {
  const TilesWithin<Bounds> tiles = bounds.tiles(shape, grid);
  const TileRect& rect = tiles.rect;
  for (int row = grid.rows.begin; row < grid.rows.end && at < end; ++row) {
    TileRun run;
    if (row >= rect.rows.begin && row < rect.rows.end) run = rect.full ? rect.columns : tiles.row(row);
    for (int column = grid.columns.begin; column < grid.columns.end && at < end; ++column)
      if (column < run.begin || column >= run.end)
        out.write(at++, grid.number(column, row), splat.depth, splat.id);
  }
}

/// Emits the splats that were set aside: a lane a row of tiles, and then a lane a tile. Should the bounds
/// find other tiles here than were counted, a splat still has as many, each once.
template <class Bounds, class Key, class ViewSource>
__global__ void __launch_bounds__(emit_threads)
    emit_large(const __grid_constant__ SplatsView all, const __grid_constant__ ViewSource views,
               const Bounds bounds, const Intersections<Key> out, const LargeSplats large) {
  await_earlier();
  const std::uint32_t warp = (blockIdx.x * emit_threads + threadIdx.x) / warp_size,
                      part = warp % warps_of_splat;
  const std::uint32_t step = gridDim.x * emit_warps / warps_of_splat;
  const std::uint32_t splats = large.counts.get();
  for (std::uint32_t s = warp / warps_of_splat, round = 0; s < splats; s += step, ++round) {
    const EmittedSplat splat = large.splats[s];
    const bool shared = splat.footprint.count > shared_from;
    if (!shared && part != round % warps_of_splat) continue;
    const SplatShape shape = all.shapes[splat.id];
    const TileGrid& grid = views[ViewSource::only ? 0 : all.view(splat.id)].grid;
    const TilesWithin<Bounds> tiles = bounds.tiles(shape, grid);
    const TileRect& rect = tiles.rect;
    std::uint32_t at = splat.at;
    const std::uint32_t end = splat.at + splat.footprint.count;
    for (int first_row = rect.rows.begin; first_row < rect.rows.end; first_row += int(warp_size)) {
      const int row = first_row + int(lane_index());
      const TileRun run = row >= rect.rows.end ? TileRun() : rect.full ? rect.columns : tiles.row(row);
      const std::uint32_t size = std::uint32_t(run.size()), first = sum_below(size);
      const std::uint32_t total = __shfl_sync(whole_warp, first + size, warp_size - 1);
      const std::uint32_t first_tile = grid.number(run.begin, row);
      for (std::uint32_t begin = shared ? part * warp_size : 0; begin < total;
           begin += shared ? warps_of_splat * warp_size : warp_size) {
        const std::uint32_t position = begin + lane_index();
        const int lane = int(owner_of(position, first));
        const std::uint32_t tile =
            __shfl_sync(whole_warp, first_tile, lane) + position - __shfl_sync(whole_warp, first, lane);
        if (position < total && at + position < end) out.write(at + position, tile, splat.depth, splat.id);
      }
      at += total;
    }
    if (at < end && lane_index() == 0 && (!shared || part == 0))
      emit_outside(bounds, shape, grid, splat, at, end, out);
  }
}

template <BoundsPolicy Bounds, class Key>
Count run_emission(Cuda& cuda, const SortJob& job, const Bounds& bounds, const std::uint32_t* order,
                   IntersectionScratch<Cuda>& scratch, Pairs<Cuda, Key>& intersections) {
  check_footprints(job);
  const Count splats = job.splats.count(), total = job.footprints.intersections;
  check_intersections(total.most);
  intersections.reset(total.most);
  if (total.most == 0 || splats.most == 0) return total;
  scratch.large.reset(splats.most);
  const unsigned blocks = blocks_for(splats.most, emit_threads);
  const EpochsView<std::uint32_t> epochs = scratch.epochs.begin(cuda, blocks);
  const Intersections<Key> out{intersections.keys.data(), intersections.values.data(),
                               std::uint32_t(total.most)};
  launch_early(cuda, "emit_intersections", emit_intersections<Key>, blocks, emit_threads,
               job.footprints.each.data, splats, job.splats.depths.data, job.footprints.views.tiles.columns,
               order, out, scratch.large.data(), epochs);
  with_views(job.footprints.views, [&]<class ViewSource>(const ViewSource& views) {
    launch_early(cuda, "emit_large", emit_large<Bounds, Key, ViewSource>, emit_large_blocks, emit_threads,
                 job.splats, views, bounds, out, LargeSplats{scratch.large.data(), epochs.last()});
  });
  scratch.epochs.end();
  return total;
}

}  // namespace swiftgs::kernels
