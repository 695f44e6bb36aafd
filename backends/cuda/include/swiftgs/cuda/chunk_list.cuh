// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

#include <swiftgs/cuda/launch.cuh>
#include <swiftgs/cuda/running_sum.cuh>
#include <swiftgs/cuda/stages.hpp>
#include <swiftgs/cuda/view_source.cuh>
#include <swiftgs/cuda/warp.cuh>
#include <swiftgs/project/chunks.hpp>

namespace swiftgs::kernels {

/// Blocks of a projection that have something to show, in ascending order. For a scene alone, block b
/// projects chunk b / views for view b % views: blocks of the same Gaussians follow each other and find them
/// in the cache. For several scenes, block b projects chunk b % chunks_a_view among the chunks that view b /
/// chunks_a_view shows.
struct BlockList {
  const std::uint32_t* blocks = nullptr;  ///< null: all
  const std::uint32_t* count = nullptr;

  __device__ std::uint32_t size() const { return blocks ? *count : gridDim.x; }
  __device__ std::uint32_t operator[](std::uint32_t i) const { return blocks ? blocks[i] : i; }
};

/// `SeveralScenes::of_chunk` by all lanes of a warp together: a step for each factor of 32 in their number.
__device__ inline const StoredScene& scene_of_chunk(const SeveralScenes& scenes, std::uint32_t chunk) {
  std::uint32_t first = 0, count = scenes.count;
  while (count > 1) {
    const std::uint32_t step = (count + warp_size - 1) / warp_size, at = lane_index() * step;
    const unsigned before =
        __ballot_sync(whole_warp, at < count && scenes.each[first + at].first_chunk <= chunk);
    const std::uint32_t last = (31 - std::uint32_t(__clz(int(before)))) * step;
    first += last, count = min(step, count - last);
  }
  return scenes.each[first];
}

/// A chunk of one of several scenes; `placed` is null where its view shows no more.
struct PlacedChunk {
  const StoredScene* placed = nullptr;
  std::uint32_t chunk = 0;  ///< of `placed`
};

/// Chunk `number` among the chunks that `view` shows. With `by_warp` all lanes ask for the same one.
template <bool by_warp>
__device__ PlacedChunk placed_chunk(const SeveralScenes& scenes, const View& view, std::uint32_t number) {
  const ShownScenes shows = view.shows;
  if (shows.first >= scenes.count) return {};
  const SeveralScenes shown{scenes.each + shows.first, min(shows.count, scenes.count - shows.first)};
  if (shown.count == 0) return {};
  const std::uint32_t in_frame = shown.each[0].first_chunk + number;
  const StoredScene& placed = by_warp ? scene_of_chunk(shown, in_frame) : shown.of_chunk(in_frame);
  const std::uint32_t chunk = in_frame - placed.first_chunk;
  if (chunk >= placed.chunks()) return {};
  return {&placed, chunk};
}

/// Whether a placed scene is valid, as its memory has it now. The block of its first chunk notes the answer.
__device__ inline bool can_be_drawn(const StoredScene& placed, std::uint32_t chunk) {
  const bool valid = placed.is_valid();
  if (chunk == 0) placed.refused = valid ? 0 : 1;
  return valid;
}

inline constexpr unsigned list_threads = 256;

/// Whether a block of a projection has something to show.
template <class ViewSource>
__device__ bool shows_some(const OneScene& scenes, const ViewSource& views, std::uint32_t,
                           std::uint32_t block) {
  const Span<const ChunkBounds>& chunks = scenes.scene.chunks;
  const std::uint32_t chunk = block / views.size();
  return chunk < chunks.size && !ChunkCuller(views[block % views.size()].camera).culls(chunks[chunk]);
}
template <class ViewSource>
__device__ bool shows_some(const SeveralScenes& scenes, const ViewSource& views, std::uint32_t chunks_a_view,
                           std::uint32_t block) {
  if (block >= views.size() * chunks_a_view) return false;
  const View& view = views[block / chunks_a_view];
  const PlacedChunk of = placed_chunk<false>(scenes, view, block % chunks_a_view);
  if (!of.placed || !can_be_drawn(*of.placed, of.chunk)) return false;
  const Span<const ChunkBounds>& chunks = of.placed->scene.chunks;
  if (chunks.empty()) return true;
  const ViewConstants camera = eye(view.camera, *of.placed);
  return !ChunkCuller(camera).culls(chunks[of.chunk]);
}

/// Lists the blocks of a projection whose chunk the view may show: a thread a block.
template <class ViewSource, class Scenes>
__global__ void __launch_bounds__(list_threads)
    list_blocks(const __grid_constant__ ViewSource views, const __grid_constant__ Scenes scenes,
                const std::uint32_t chunks_a_view, std::uint32_t* blocks, std::uint32_t* count,
                const EpochsView<NoCounts> epochs) {
  __shared__ std::uint32_t shown_by_warp[list_threads / warp_size], shared_before;
  const std::uint32_t epoch = read_epoch(epochs);
  const std::uint32_t block = blockIdx.x * list_threads + threadIdx.x;
  const bool shown = shows_some(scenes, views, chunks_a_view, block);

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

/// The blocks of a projection of `blocks` blocks, in memory of `scratch`. Takes that memory also for scenes
/// without chunks: a recorded frame may draw one with chunks later.
inline BlockList run_list_blocks(Cuda& cuda, const FramePlan& plan, unsigned blocks, unsigned chunks_a_view,
                                 BlockScratch& scratch) {
  const unsigned grid = blocks_for(blocks, list_threads);
  scratch.blocks.reset(blocks), scratch.count.reset(1);
  const EpochsView<NoCounts> epochs = scratch.epochs.begin(cuda, grid);
  const bool some_chunks = std::any_of(plan.scenes.each().begin(), plan.scenes.each().end(),
                                       [](const StoredScene& of) { return !of.scene.chunks.empty(); });
  const bool listed = some_chunks && blocks >= least_listed * unsigned(cuda.multiprocessors());
  if (listed)
    with_views_and_scenes(plan.views, plan.scenes,
                          [&]<class ViewSource, class Scenes>(const ViewSource& views, const Scenes& scenes) {
                            launch("list_blocks", list_blocks<ViewSource, Scenes>, grid, list_threads,
                                   cuda.stream(), views, scenes, chunks_a_view, scratch.blocks.data(),
                                   scratch.count.data(), epochs);
                          });
  scratch.epochs.end();
  return listed ? BlockList{scratch.blocks.data(), scratch.count.data()} : BlockList{};
}

}  // namespace swiftgs::kernels
