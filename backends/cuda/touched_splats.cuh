// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <cooperative_groups.h>

#include <swiftgs/cuda/warp.cuh>
#include <swiftgs/frame/raster.hpp>

#include "exponents.hpp"
#include "work_queue.cuh"

namespace swiftgs::kernels {

/// Blocks that work on one thing: one, or the `blocks_of_group` of a cluster.
inline constexpr unsigned blocks_of_group = 8;

struct Group {
  unsigned rank = 0, blocks = 1;

  /// The cluster of this block.
  __device__ static Group cluster() {
#if __CUDA_ARCH__ >= 900
    const auto all = cooperative_groups::this_cluster();
    if (all.num_blocks() == blocks_of_group) return {all.block_rank(), blocks_of_group};
#endif
    return {};
  }

  __device__ void sync() const {
#if __CUDA_ARCH__ >= 900
    if (blocks != 1) {
      cooperative_groups::this_cluster().sync();
      return;
    }
#endif
    __syncthreads();
  }

  /// `mine` in the shared memory of block `block`.
  template <class T>
  __device__ T& in(unsigned block, T& mine) const {
#if __CUDA_ARCH__ >= 900
    if (blocks != 1) return *cooperative_groups::this_cluster().map_shared_rank(&mine, block);
#endif
    return mine;
  }
};

/// Finds the splats that touch a warp block, by all threads of a group, in list order. They lie in rings in
/// shared memory, each in that of the thread block that blends it: one blends `share` of them, the next the
/// next `share`.
template <unsigned warps, unsigned share, unsigned most>
class TouchedSplats {
  static constexpr unsigned tests_of_thread = 4, tests_of_block = tests_of_thread * warps * warp_size;
  static constexpr unsigned ring_size = most + tests_of_block;
  static_assert(tests_of_thread * warps <= warp_size, "a warp adds up what all have found");
  static_assert(tests_of_block <= share && 2 * share <= ring_size, "a ring holds two rounds");

 public:
  struct Shared {
    std::uint32_t ids[ring_size];
    // Splats that touch, of those tested; the halves alternate.
    std::uint32_t touched[2][warp_size];           ///< of each 32 of this thread block
    std::uint32_t touched_of[2][blocks_of_group];  ///< of each thread block
  };

  /// Call it after the group has synchronised.
  __device__ TouchedSplats(Shared& shared, const RasterJob& job, const Group& group, ResumeAt from,
                           std::uint32_t end)
      : shared_(shared), job_(job), group_(group), at_(from.position), end_(end), skip_(from.skipped) {
    load_next();
  }

  /// Splats found and not dropped.
  __device__ std::uint32_t count() const { return count_; }
  /// The k-th of them in this thread block's ring.
  __device__ std::uint32_t id(std::uint32_t k) const { return shared_.ids[in_ring(first_ + k)]; }

  /// Finds splats until there are `wanted`, or the list ends: at most `most`, or with a cluster the share of
  /// each block. Synchronises the group.
  __device__ void find(vec2 first_centre, std::uint32_t wanted) {
    const bool some_colourless = job_.colours.some_colourless();
    const unsigned warp = threadIdx.x / warp_size;
    for (unsigned half = 0; count_ < wanted && at_ < end_; half ^= 1) {
      // Test. Load all shapes before the first is needed.
      std::uint32_t ids[tests_of_thread];
      SplatShape shapes[tests_of_thread];
      unsigned lanes[tests_of_thread];
#pragma unroll
      for (unsigned k = 0; k < tests_of_thread; ++k) {
        ids[k] = next_[k];
        shapes[k] = load_shape(job_.splats, ids[k]);
      }
#pragma unroll
      for (unsigned k = 0; k < tests_of_thread; ++k) {
        bool touched = at_ + first_of_thread() + k * warp_size < end_ &&
                       box_touched(shapes[k], first_centre, float(warp_block_side));
        if (some_colourless) touched = touched && !is_colourless(job_.colours.each[ids[k]]);
        lanes[k] = __ballot_sync(whole_warp, touched);
      }
      if (lane_index() == 0)
#pragma unroll
        for (unsigned k = 0; k < tests_of_thread; ++k)
          shared_.touched[half][warp * tests_of_thread + k] = std::uint32_t(__popc(lanes[k]));
      __syncthreads();

      // Store each behind those before it in the list.
      const std::uint32_t mine = shared_.touched[half][lane_index()], before = sum_below(mine);
      std::uint32_t found = __shfl_sync(whole_warp, before + mine, warp_size - 1), before_block = 0;
      if (group_.blocks != 1) {
        if (threadIdx.x < group_.blocks)
          group_.in(threadIdx.x, shared_).touched_of[half][group_.rank] = found;
        group_.sync();
        found = 0;
        for (unsigned b = 0; b < group_.blocks; ++b) {
          if (b == group_.rank) before_block = found;
          found += shared_.touched_of[half][b];
        }
      }
#pragma unroll
      for (unsigned k = 0; k < tests_of_thread; ++k) {
        const std::uint32_t nth = before_block +
                                  __shfl_sync(whole_warp, before, int(warp * tests_of_thread + k)) +
                                  std::uint32_t(__popc(lanes[k] & lanes_below()));
        if ((lanes[k] >> lane_index() & 1) && nth >= skip_) store(count_ + nth - skip_, ids[k]);
      }
      last_ = at_, found_ = found;
      count_ += found - min(skip_, found), skip_ -= min(skip_, found);
      at_ += min(group_.blocks * tests_of_block, end_ - at_);
      load_next();
    }
    group_.sync();
  }

  /// Drops the first `count`: with a cluster, the share of each block.
  __device__ void drop(std::uint32_t count) {
    first_ = in_ring(first_ + (group_.blocks == 1 ? count : share));
    count_ -= count;
  }

  /// Where the splats begin that are found and not dropped, if the last tests have found them all.
  __device__ ResumeAt next() const { return {last_, found_ - count_ + skip_}; }

 private:
  __device__ unsigned first_of_thread() const {
    return (group_.rank * warps + threadIdx.x / warp_size) * tests_of_thread * warp_size + lane_index();
  }
  /// Loads the ids that are tested next.
  __device__ void load_next() {
#pragma unroll
    for (unsigned k = 0; k < tests_of_thread; ++k) {
      const std::uint32_t position = at_ + first_of_thread() + k * warp_size;
      next_[k] = position < end_ ? job_.lists.ids[position] : 0;
    }
  }
  /// Stores the k-th splat in its thread block's ring.
  __device__ void store(std::uint32_t k, std::uint32_t id) const {
    if (group_.blocks == 1) {
      shared_.ids[in_ring(first_ + k)] = id;
    } else {
      const unsigned round = k / (share * blocks_of_group), block = k / share % blocks_of_group;
      group_.in(block, shared_).ids[in_ring(first_ + round * share + k % share)] = id;
    }
  }
  __device__ static std::uint32_t in_ring(std::uint32_t k) { return k < ring_size ? k : k - ring_size; }

  Shared& shared_;
  const RasterJob& job_;
  const Group group_;
  std::uint32_t next_[tests_of_thread];   ///< ids
  std::uint32_t at_, end_;                ///< intersections that are not tested yet
  std::uint32_t skip_;                    ///< touching splats to skip
  std::uint32_t last_ = at_, found_ = 0;  ///< where the last tests began, and what they found
  std::uint32_t first_ = 0, count_ = 0;
};

}  // namespace swiftgs::kernels
