// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <cuda/atomic>

#include <swiftgs/cuda/epochs.hpp>
#include <swiftgs/cuda/warp.cuh>

namespace swiftgs::kernels {

/// The epoch of this kernel's operation. A thread reads it before its thread block publishes a word. The
/// block that ends the epoch waits for all words, so no read follows.
template <class Counters>
__device__ std::uint32_t read_epoch(const EpochsView<Counters>& epochs) {
  // Not to be moved to where it is needed, and from the multiprocessor's cache where another block asked.
  std::uint32_t epoch;
  asm volatile("ld.global.ca.u32 %0, [%1];" : "=r"(epoch) : "l"(&epochs.counters->epoch));
  return epoch;
}

/// Ends the epoch of an operation with a word for each of `blocks`. Call it from one thread of the last
/// block, after its look-back.
template <class Counters>
__device__ void end_epoch(const EpochsView<Counters>& epochs, std::uint32_t epoch, std::uint32_t blocks) {
  const std::uint32_t swept = swept_word(epoch, 1, epochs.mask);
  if (swept >= blocks && swept < epochs.capacity) epochs.words[swept] = 0;
  epochs.counters->epoch = epoch_after(epoch);
}

/// One word of a running sum: its tag, how much is known, and the sum, so that nothing beside it has to be
/// ordered. Words with other tags are there to be overwritten.
class SumWord {
 public:
  /// A block's own value; the sum up to and with it.
  static constexpr std::uint32_t partial = 1, complete = 2;

  __device__ SumWord() : bits_(0) {}
  __device__ SumWord(std::uint32_t tag, std::uint32_t known, std::uint32_t value)
      : bits_(std::uint64_t(tag << 2 | known) << 32 | value) {}

  __device__ std::uint32_t tag() const { return std::uint32_t(bits_ >> 34); }
  __device__ std::uint32_t known() const { return std::uint32_t(bits_ >> 32 & 3); }
  __device__ std::uint32_t value() const { return std::uint32_t(bits_); }

  __device__ void write(std::uint64_t& word) const { Atomic(word).store(bits_, cuda::memory_order_relaxed); }
  __device__ static SumWord read(std::uint64_t& from) {
    SumWord word;
    word.bits_ = Atomic(from).load(cuda::memory_order_relaxed);
    return word;
  }

 private:
  using Atomic = cuda::atomic_ref<std::uint64_t, cuda::thread_scope_device>;
  std::uint64_t bits_;
};

/// A sum over the thread blocks of one kernel while they run: single-pass scan with decoupled look-back
/// (Merrill and Garland 2016), one word per block. A block waits for those of lower indices: devices start
/// blocks in index order, on which CUB's scan relies too.
class RunningSum {
 public:
  __device__ RunningSum(std::uint64_t* words, std::uint32_t epoch) : words_(words), tag_(tag_of(epoch)) {}

  /// Tells later blocks the value of this one. For one thread.
  __device__ void add(std::uint32_t value) const {
    publish(blockIdx.x == 0 ? SumWord::complete : SumWord::partial, value);
  }

  /// Sum of all blocks before this one, which adds `value`. For one whole warp.
  __device__ std::uint32_t before(std::uint32_t value) const {
    std::uint32_t sum = 0;
    for (std::uint32_t end = blockIdx.x; end != 0; end -= min(end, warp_size)) {
      // Each lane looks at one block, lane 0 at the nearest. Those before the first block add nothing.
      // Looking at 128 or more at once takes longer: repeated reads delay what others publish.
      const unsigned back = lane_index();
      SumWord word = back < end ? read(end - 1 - back) : SumWord(tag_, SumWord::complete, 0);
      while (word.tag() != tag_) word = read(end - 1 - back);
      // Add the nearest complete sum and the values after it.
      const unsigned complete_lanes = __ballot_sync(whole_warp, word.known() == SumWord::complete);
      const unsigned nearest = complete_lanes ? unsigned(__ffs(int(complete_lanes))) - 1 : warp_size;
      sum += warp_sum(back <= nearest ? word.value() : 0);
      if (complete_lanes) break;
    }
    if (lane_index() == 0 && blockIdx.x != 0) publish(SumWord::complete, sum + value);
    return sum;
  }

 private:
  __device__ void publish(std::uint32_t known, std::uint32_t value) const {
    SumWord(tag_, known, value).write(words_[blockIdx.x]);
  }
  __device__ SumWord read(std::uint32_t block) const { return SumWord::read(words_[block]); }

  std::uint64_t* words_;
  std::uint32_t tag_;
};

}  // namespace swiftgs::kernels
