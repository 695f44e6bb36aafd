// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <swiftgs/chunks.hpp>
#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/launch.cuh>
#include <swiftgs/cuda/running_sum.cuh>
#include <swiftgs/cuda/view_source.cuh>
#include <swiftgs/cuda/warp.cuh>

namespace swiftgs::kernels {

/// Which blocks of a projection have something to show, in ascending order: block b projects chunk
/// b / views for view b % views.
struct BlockList {
  const std::uint32_t* blocks = nullptr;  ///< null: all
  const std::uint32_t* count = nullptr;

  __device__ std::uint32_t size() const { return blocks ? *count : gridDim.x; }
  __device__ std::uint32_t operator[](std::uint32_t i) const { return blocks ? blocks[i] : i; }
};

inline constexpr unsigned list_threads = 256;

/// Lists the blocks of a projection whose chunk the view may show: a thread a block.
template <class ViewSource>
__global__ void __launch_bounds__(list_threads)
    list_blocks(const __grid_constant__ ViewSource views, const Span<const ChunkBounds> chunks,
                std::uint32_t* blocks, std::uint32_t* count, const EpochsView<NoCounts> epochs) {
  __shared__ std::uint32_t shown_by_warp[list_threads / warp_size], shared_before;
  const std::uint32_t epoch = read_epoch(epochs);
  const std::uint32_t block = blockIdx.x * list_threads + threadIdx.x, chunk = block / views.size();
  const bool shown =
      chunk < chunks.size && !ChunkCuller(views[block % views.size()].camera).hides(chunks[chunk]);

  const unsigned lanes = __ballot_sync(whole_warp, shown), warp = threadIdx.x / warp_size;
  if (lane_index() == 0) shown_by_warp[warp] = std::uint32_t(__popc(lanes));
  __syncthreads();
  std::uint32_t slot = std::uint32_t(__popc(lanes & lanes_below())), all = 0;
  for (unsigned w = 0; w < list_threads / warp_size; ++w) {
    if (w < warp) slot += shown_by_warp[w];
    all += shown_by_warp[w];
  }
  if (warp == 0) {
    const RunningSum sum(epochs.words, epoch);
    if (threadIdx.x == 0) sum.add(all);
    const std::uint32_t before = sum.before(all);
    if (threadIdx.x == 0) {
      shared_before = before;
      if (blockIdx.x + 1 == gridDim.x) {
        *count = before + all;
        end_epoch(epochs, epoch, gridDim.x);
      }
    }
  }
  __syncthreads();
  if (shown) blocks[shared_before + slot] = block;
}

/// A list pays from so many thread blocks per multiprocessor on. Fewer run all at once, so leaving some out
/// saves no time: on an H200 frames of fox, with 10 per multiprocessor, take 1 % longer with a list.
inline constexpr unsigned least_listed = 16;

/// The blocks of a projection of `blocks` blocks, in memory of `scratch`. Takes that memory also for a scene
/// without chunks: a recorded frame may draw one with chunks later.
inline BlockList run_list_blocks(Cuda& cuda, const FramePlan& plan, unsigned blocks, BlockScratch& scratch) {
  const unsigned grid = blocks_for(blocks, list_threads);
  scratch.blocks.reset(blocks), scratch.count.reset(1);
  const EpochsView<NoCounts> epochs = scratch.epochs.begin(cuda, grid);
  const Span<const ChunkBounds> chunks = plan.scene.chunks;
  const bool listed = !chunks.empty() && blocks >= least_listed * unsigned(cuda.multiprocessors());
  if (listed)
    with_views(plan.views, [&]<class ViewSource>(const ViewSource& views) {
      launch("list_blocks", list_blocks<ViewSource>, grid, list_threads, cuda.stream(), views, chunks,
             scratch.blocks.data(), scratch.count.data(), epochs);
    });
  scratch.epochs.end();
  return listed ? BlockList{scratch.blocks.data(), scratch.count.data()} : BlockList{};
}

}  // namespace swiftgs::kernels
