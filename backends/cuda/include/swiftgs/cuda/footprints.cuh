// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <swiftgs/cuda/stages.hpp>
#include <swiftgs/cuda/warp.cuh>
#include <swiftgs/frame/bounds.hpp>

namespace swiftgs::kernels {

/// Spreads the tile rows of a warp's 32 splats evenly over its lanes, lane after lane, so that a splat of
/// many rows does not keep one lane busy. `tiles` are those of the warp's splats, `rect` is the lane's, empty
/// if it has none. Calls f(owner, row, run) on all lanes together; lanes without a row get an empty run.
template <class Tiles, class F>
__device__ void for_each_row(const Tiles* tiles, TileRect rect, const F& f) {
  const std::uint32_t rows = rect.columns.size() == 0 ? 0 : std::uint32_t(rect.rows.size());
  const std::uint32_t first = sum_below(rows);
  const std::uint32_t total = __shfl_sync(whole_warp, first + rows, warp_size - 1);
  for (std::uint32_t begin = 0; begin < total; begin += warp_size) {
    const std::uint32_t position = begin + lane_index();
    const unsigned owner = owner_of(position, first);
    const auto of_owner = [&](auto value) { return __shfl_sync(whole_warp, value, int(owner)); };
    const int row = of_owner(rect.rows.begin) + int(position - of_owner(first));
    TileRun run;
    if (position < total) run = tiles[owner].row(row);
    f(owner, row, run);
  }
}

/// Shared memory in which a warp finds footprints.
template <class Bounds>
struct FootprintShared {
  SharedArray<TilesWithin<Bounds>, warp_size> tiles;
  std::uint32_t counts[warp_size], masks[2][warp_size];
};

/// Footprint of each lane's splat, where it has one.
template <class Bounds>
__device__ Footprint find_footprint(const Bounds& bounds, const TileGrid& grid, const SplatShape& shape,
                                    bool exists, FootprintShared<Bounds>& shared) {
  const unsigned lane = lane_index();
  TileRect rect;
  if (exists) {
    const TilesWithin<Bounds> tiles = bounds.tiles(shape, grid);
    shared.tiles.data()[lane] = tiles, rect = tiles.rect;
  }
  // A full box, as most small splats have, takes no row of the warp's.
  const bool fits = rect.columns.size() <= Footprint::side && rect.rows.size() <= Footprint::side;
  const int found = rect.full ? rect.columns.size() * rect.rows.size() : 0;
  const std::uint64_t mask = fits && found > 0 ? detail::full_mask(rect) : 0;
  shared.counts[lane] = std::uint32_t(found);
  shared.masks[0][lane] = std::uint32_t(mask), shared.masks[1][lane] = std::uint32_t(mask >> 32);
  __syncwarp();
  for_each_row(shared.tiles.data(), rect.full ? TileRect() : rect, [&](unsigned owner, int row, TileRun run) {
    const int below = row - __shfl_sync(whole_warp, rect.rows.begin, int(owner));
    const int right = run.begin - __shfl_sync(whole_warp, rect.columns.begin, int(owner));
    if (run.size() == 0) return;
    atomicAdd(&shared.counts[owner], std::uint32_t(run.size()));
    if (below < Footprint::side && right >= 0 && right + run.size() <= Footprint::side)
      atomicOr(&shared.masks[below / 4][owner], ((1u << run.size()) - 1)
                                                    << (right + below % 4 * Footprint::side));
  });
  __syncwarp();
  return {fits ? std::uint64_t(shared.masks[1][lane]) << 32 | shared.masks[0][lane] : 0, shared.counts[lane],
          grid.number(rect.columns.begin, rect.rows.begin)};
}

/// Adds to the tiles of a frame's splats. For one thread.
__device__ inline void add_intersections(FrameCounts& counts, std::uint32_t tiles) {
  static_assert(sizeof(unsigned long long) == sizeof counts.intersections);
  if (tiles != 0)
    atomicAdd(reinterpret_cast<unsigned long long*>(&counts.intersections),
              static_cast<unsigned long long>(tiles));
}

inline constexpr unsigned bin_threads = 256;

/// Finds footprints outside of projection, and counts the splats.
template <class Bounds, class ViewSource>
__global__ void __launch_bounds__(bin_threads)
    find_footprints(const __grid_constant__ SplatsView splats, const __grid_constant__ ViewSource views,
                    const Bounds bounds, Footprint* footprints, FrameCounts* counts) {
  __shared__ FootprintShared<Bounds> shared[bin_threads / warp_size];
  const std::size_t i = std::size_t(blockIdx.x) * bin_threads + threadIdx.x;
  const bool exists = i < splats.size();
  SplatShape shape;
  if (exists) shape = splats.shapes[i];
  const TileGrid& grid = views[exists ? splats.view(i) : 0].grid;
  const Footprint found = find_footprint(bounds, grid, shape, exists, shared[threadIdx.x / warp_size]);
  if (exists) footprints[i] = found;
  const std::uint32_t tiles = warp_sum(found.count);
  if (lane_index() == 0) add_intersections(*counts, tiles);
  if (i == 0) counts->visible = splats.size();
}

}  // namespace swiftgs::kernels
