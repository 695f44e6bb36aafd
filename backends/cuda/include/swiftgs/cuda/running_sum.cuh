// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <cuda/atomic>

#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/warp.cuh>

namespace swiftgs::kernels {

/// A sum that runs over the blocks of one kernel, in order, while they run (Merrill and Garland 2016,
/// single-pass scan with decoupled look-back). One word a block holds the epoch, how much is known, and the
/// sum, so that nothing beside it has to be ordered. A block waits for those of a lower index: devices start
/// blocks in the order of their indices, on which CUB's scan relies too.
class RunningSum {
 public:
  __device__ explicit RunningSum(RunningSums::View sums) : sums_(sums) {}

  /// Tells later blocks what this one adds. For one thread.
  __device__ void add(std::uint32_t value) { publish(blockIdx.x == 0 ? complete : partial, value); }

  /// Sum of all blocks before this one, which adds `value`. For one whole warp.
  __device__ std::uint32_t before(std::uint32_t value) {
    std::uint32_t sum = 0;
    for (std::uint32_t end = blockIdx.x; end != 0; end -= min(end, window)) {
      // Look at a window of blocks, the nearest on lane 0. Those before the first block add nothing.
      std::uint64_t words[words_of_lane];
#pragma unroll
      for (unsigned k = 0; k < words_of_lane; ++k) {
        const unsigned back = lane_index() * words_of_lane + k;
        words[k] = back < end ? read(end - 1 - back) : std::uint64_t(complete) << 32;
      }
      // Add up what lies after the nearest complete sum, and that.
      std::uint32_t of_lane = 0;
      bool found = false;
#pragma unroll
      for (unsigned k = 0; k < words_of_lane; ++k) {
        const unsigned back = lane_index() * words_of_lane + k;
        while (back < end && words[k] >> 34 != sums_.epoch) words[k] = read(end - 1 - back);
        if (!found) of_lane += std::uint32_t(words[k]);
        found = found || (words[k] >> 32 & 3) == complete;
      }
      const unsigned complete_lanes = __ballot_sync(whole_warp, found);
      const unsigned nearest = complete_lanes ? unsigned(__ffs(int(complete_lanes))) - 1 : warp_size;
      sum += warp_sum(lane_index() <= nearest ? of_lane : 0);
      if (complete_lanes) break;
    }
    if (lane_index() == 0 && blockIdx.x != 0) publish(complete, sum + value);
    return sum;
  }

 private:
  /// A wide window, since many blocks that have not looked back yet lie between a block and the last that
  /// has.
  static constexpr unsigned words_of_lane = 4, window = words_of_lane * warp_size;
  static constexpr std::uint32_t partial = 1,
                                 complete = 2;  ///< the block's own value; the sum up to and with it

  using Word = cuda::atomic_ref<std::uint64_t, cuda::thread_scope_device>;
  __device__ void publish(std::uint32_t known, std::uint32_t value) {
    const std::uint64_t word = std::uint64_t(sums_.epoch << 2 | known) << 32 | value;
    Word(sums_.states[blockIdx.x]).store(word, cuda::memory_order_relaxed);
  }
  __device__ std::uint64_t read(std::uint32_t block) const {
    return Word(sums_.states[block]).load(cuda::memory_order_relaxed);
  }

  RunningSums::View sums_;
};

}  // namespace swiftgs::kernels
