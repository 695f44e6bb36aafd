// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/warp.cuh>

namespace swiftgs::kernels {

/// A sum that runs over the blocks of one kernel, in order, while they run (Merrill and Garland 2016,
/// single-pass scan with decoupled look-back). One word a block holds the epoch, how much is known, and the sum,
/// so that nothing beside it has to be ordered.
class RunningSum {
 public:
  __device__ explicit RunningSum(RunningSums::View sums) : sums_(sums) {}

  /// Place of this block in the sum: blocks are numbered in the order in which they start, since a block waits for
  /// those before it. For one thread of the block.
  __device__ std::uint32_t take_place(std::uint32_t blocks) {
    const std::uint32_t place = atomicAdd(sums_.ticket, 1u);
    if (place + 1 == blocks) *sums_.ticket = 0;  // all places are taken: the next kernel starts from 0
    return place;
  }

  /// Tells later blocks what this one adds. For one thread.
  __device__ void add(std::uint32_t place, std::uint32_t value) {
    publish(place, place == 0 ? complete : partial, value);
  }

  /// Sum of all blocks before this one, which adds `value`. For one whole warp.
  __device__ std::uint32_t before(std::uint32_t place, std::uint32_t value) {
    const unsigned lane = threadIdx.x % warp_size;
    std::uint32_t sum = 0;
    for (std::uint32_t end = place; end != 0; end -= end < warp_size ? end : warp_size) {
      // Lane 0 looks at the nearest block. Lanes before the first block add nothing.
      std::uint64_t word = std::uint64_t(complete) << 32;
      if (lane < end) word = wait_for(end - 1 - lane);
      const unsigned complete_lanes = __ballot_sync(whole_warp, (word >> 32 & 3) == complete);
      const unsigned nearest = complete_lanes ? unsigned(__ffs(int(complete_lanes))) - 1 : warp_size;
      sum += warp_sum(lane <= nearest ? std::uint32_t(word) : 0);
      if (complete_lanes) break;
    }
    if (lane == 0 && place != 0) publish(place, complete, sum + value);
    return sum;
  }

 private:
  static constexpr std::uint32_t partial = 1, complete = 2;  ///< the block's own value; the sum up to and with it

  __device__ void publish(std::uint32_t place, std::uint32_t known, std::uint32_t value) {
    const std::uint64_t word = std::uint64_t(sums_.epoch << 2 | known) << 32 | value;
    *static_cast<volatile std::uint64_t*>(sums_.states + place) = word;
  }
  __device__ std::uint64_t wait_for(std::uint32_t place) const {
    std::uint64_t word;
    do word = *static_cast<const volatile std::uint64_t*>(sums_.states + place);
    while (word >> 34 != sums_.epoch);
    return word;
  }

  RunningSums::View sums_;
};

}  // namespace swiftgs::kernels
