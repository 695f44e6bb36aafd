// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>

#include <swiftgs/cuda/launch.cuh>
#include <swiftgs/cuda/raster_block.cuh>
#include <swiftgs/cuda/warp.cuh>

#include "state.hpp"

namespace swiftgs::kernels {
namespace {

/// Each thread block orders every 16th raster block. With one thread block, this would take three times as
/// long.
/// Measured on an H200: with one, rasterizing takes 2 microseconds longer in garden and 4 in fox.
constexpr unsigned order_blocks = 16, order_threads = 512;

/// Lists of a class differ in length by a quarter at most. Longer lists are in lower classes.
constexpr unsigned length_classes = 128;
static_assert(length_classes % warp_size == 0 && length_classes <= order_threads);

__device__ unsigned class_of(TileRange list) {
  const std::uint32_t length = list.drawn() ? list.end - list.begin : 0;
  if (length < 4) return length_classes - 1 - length;
  const unsigned octave = 31 - unsigned(__clz(int(length)));
  return length_classes - 1 - (4 * (octave - 1) + (length >> (octave - 2) & 3));
}

/// The k-th of `order_blocks` thread blocks fills every position k modulo `order_blocks`.
__global__ void __launch_bounds__(order_threads)
    fill_order(const TileListsView lists, const RasterBlocks raster_blocks, std::uint32_t* order) {
  __shared__ std::uint32_t positions[length_classes];
  if (threadIdx.x < length_classes) positions[threadIdx.x] = 0;
  __syncthreads();
  const std::uint32_t count = std::uint32_t(raster_blocks.size());
  const auto for_each_raster_block = [&](const auto& f) {
    for (std::uint32_t s = threadIdx.x * order_blocks + blockIdx.x; s < count;
         s += order_threads * order_blocks) {
      const RasterBlockIndex index{s % raster_blocks.columns, s / raster_blocks.columns};
      const std::uint32_t tile =
          index.row / raster_blocks.of_tile * (raster_blocks.columns / raster_blocks.of_tile) +
          index.column / raster_blocks.of_tile;
      f(index, class_of(lists.ranges[tile]));
    }
  };
  for_each_raster_block([&](RasterBlockIndex, unsigned of_class) { atomicAdd(&positions[of_class], 1u); });
  __syncthreads();
  if (threadIdx.x < warp_size) {
    // Counts to positions: each lane has some neighbouring classes.
    constexpr unsigned each = length_classes / warp_size;
    std::uint32_t sum = 0;
    for (unsigned k = 0; k < each; ++k) sum += positions[threadIdx.x * each + k];
    std::uint32_t position = sum_below(sum);
    for (unsigned k = 0; k < each; ++k) {
      const std::uint32_t of_class = positions[threadIdx.x * each + k];
      positions[threadIdx.x * each + k] = position;
      position += of_class;
    }
  }
  __syncthreads();
  for_each_raster_block([&](RasterBlockIndex index, unsigned of_class) {
    order[atomicAdd(&positions[of_class], 1u) * order_blocks + blockIdx.x] = index.word();
  });
}

/// Thread blocks of `raster_warps` that a multiprocessor holds at once, and the most rounds of them for which
/// an order pays: on an H200 it gains 6 of 144 microseconds in garden, which has 3.7 rounds, and nothing
/// beyond 6 rounds.
constexpr std::size_t blocks_at_once = 9, most_rounds = 8;

}  // namespace

const std::uint32_t* order_raster_blocks(Cuda& cuda, const TileListsView& lists,
                                         const RasterBlocks& raster_blocks) {
  const std::size_t at_once = blocks_at_once * std::size_t(cuda.multiprocessors());
  if (raster_blocks.size() <= at_once) return nullptr;
  // As much for every frame, so that none takes memory after a larger one.
  RasterMemory& raster = RasterMemory::of(cuda);
  std::uint32_t* const order = raster.at_least(cuda, raster.order, most_rounds * at_once);
  // Words have 16 bits for a column and for a row. A grid in slices has more thread blocks than raster
  // blocks.
  if (raster_blocks.size() > most_rounds * at_once || raster_blocks.rows > rows_of_slice ||
      raster_blocks.columns > 65535)
    return nullptr;
  launch("fill_order", fill_order, order_blocks, order_threads, cuda.stream(), lists, raster_blocks, order);
  return order;
}

}  // namespace swiftgs::kernels
