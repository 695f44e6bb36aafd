// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <cuda/atomic>

#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/warp.cuh>

namespace swiftgs::kernels {

/// One word of a running sum: its epoch, how much is known, and the sum, so that nothing beside it has to be
/// ordered. Words of earlier epochs are there to be overwritten.
class SumWord {
 public:
  /// A block's own value; the sum up to and with it.
  static constexpr std::uint32_t partial = 1, complete = 2;

  __device__ SumWord() : bits_(0) {}
  __device__ SumWord(std::uint32_t epoch, std::uint32_t known, std::uint32_t value)
      : bits_(std::uint64_t(epoch << 2 | known) << 32 | value) {}

  __device__ std::uint32_t epoch() const { return std::uint32_t(bits_ >> 34); }
  __device__ std::uint32_t known() const { return std::uint32_t(bits_ >> 32 & 3); }
  __device__ std::uint32_t value() const { return std::uint32_t(bits_); }

  __device__ void write(std::uint64_t& state) const {
    Atomic(state).store(bits_, cuda::memory_order_relaxed);
  }
  __device__ static SumWord read(std::uint64_t& state) {
    SumWord word;
    word.bits_ = Atomic(state).load(cuda::memory_order_relaxed);
    return word;
  }

 private:
  using Atomic = cuda::atomic_ref<std::uint64_t, cuda::thread_scope_device>;
  std::uint64_t bits_;
};

/// A sum that runs over the blocks of one kernel, in order, while they run (Merrill and Garland 2016,
/// single-pass scan with decoupled look-back), by one word a block. A block waits for those of a lower index:
/// devices start blocks in the order of their indices, on which CUB's scan relies too.
class RunningSum {
 public:
  __device__ explicit RunningSum(RunningSums::View sums) : sums_(sums) {}

  /// Tells later blocks what this one adds. For one thread.
  __device__ void add(std::uint32_t value) {
    publish(blockIdx.x == 0 ? SumWord::complete : SumWord::partial, value);
  }

  /// Sum of all blocks before this one, which adds `value`. For one whole warp.
  __device__ std::uint32_t before(std::uint32_t value) {
    std::uint32_t sum = 0;
    for (std::uint32_t end = blockIdx.x; end != 0; end -= min(end, window)) {
      // Look at a window of blocks, the nearest on lane 0. Those before the first block add nothing.
      SumWord words[words_of_lane];
#pragma unroll
      for (unsigned k = 0; k < words_of_lane; ++k) {
        const unsigned back = lane_index() * words_of_lane + k;
        words[k] = back < end ? read(end - 1 - back) : SumWord(sums_.epoch, SumWord::complete, 0);
      }
      // Add up what lies after the nearest complete sum, and that.
      std::uint32_t of_lane = 0;
      bool found = false;
#pragma unroll
      for (unsigned k = 0; k < words_of_lane; ++k) {
        const unsigned back = lane_index() * words_of_lane + k;
        while (words[k].epoch() != sums_.epoch) words[k] = read(end - 1 - back);
        if (!found) of_lane += words[k].value();
        found = found || words[k].known() == SumWord::complete;
      }
      const unsigned complete_lanes = __ballot_sync(whole_warp, found);
      const unsigned nearest = complete_lanes ? unsigned(__ffs(int(complete_lanes))) - 1 : warp_size;
      sum += warp_sum(lane_index() <= nearest ? of_lane : 0);
      if (complete_lanes) break;
    }
    if (lane_index() == 0 && blockIdx.x != 0) publish(SumWord::complete, sum + value);
    return sum;
  }

 private:
  /// A wide window, since many blocks that have not looked back yet lie between a block and the last that
  /// has.
  static constexpr unsigned words_of_lane = 4, window = words_of_lane * warp_size;

  __device__ void publish(std::uint32_t known, std::uint32_t value) {
    SumWord(sums_.epoch, known, value).write(sums_.states[blockIdx.x]);
  }
  __device__ SumWord read(std::uint32_t block) const { return SumWord::read(sums_.states[block]); }

  RunningSums::View sums_;
};

}  // namespace swiftgs::kernels
