// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Memory that one operation (a projection, an emission, a sort) shares with the next of its kind. The
/// device counts operations in epochs. Launch arguments never change between frames, so a CUDA graph can
/// replay them.

#include <cstdint>

#include <swiftgs/frame/math.hpp>

namespace swiftgs {

namespace kernels {

/// Epochs are numbers of operations. Their number is even, so that copies still alternate after the last
/// epoch, and so small that a tag fits the 30 bits that a word has for it.
inline constexpr std::uint32_t epochs_in_all = (1u << 27) - 2;
/// Kernels of one operation that write the same words.
inline constexpr std::uint32_t most_passes = 8;

SWIFTGS_HD constexpr std::uint32_t epoch_after(std::uint32_t epoch) {
  return epoch + 1 == epochs_in_all ? 0 : epoch + 1;
}

/// Tag that an operation writes beside its sums: words with another tag are older. Never 0, which cleared
/// memory holds.
SWIFTGS_HD constexpr std::uint32_t tag_of(std::uint32_t epoch, std::uint32_t pass = 0) {
  return epoch * most_passes + pass + 1;
}

/// The copy of the counters to which an operation adds; it clears the other one.
SWIFTGS_HD constexpr unsigned copy_of(std::uint32_t epoch) { return epoch % 2; }

/// Tags repeat after hours, and a word unused since would then pass for a new one. So each operation clears
/// the `row` words from this one on that it does not use. `mask` is one less than a power of two: the rows
/// below it are swept one after another.
SWIFTGS_HD constexpr std::uint32_t swept_word(std::uint32_t epoch, std::uint32_t row, std::uint32_t mask) {
  return epoch * row & mask;
}

}  // namespace kernels

/// Counters of the last operation, for kernels that come after it.
template <class Counters>
struct LastCounters {
  const Counters* copies = nullptr;      ///< null: none
  const std::uint32_t* epoch = nullptr;  ///< of the operation that comes next; null: there is one copy

  bool operator==(const LastCounters&) const = default;

  /// Loads both copies with `epoch`: a load that waits for it would take twice as long.
  SWIFTGS_HD Counters get() const {
    const Counters even = copies[0], odd = copies[epoch ? 1 : 0];
    return kernels::copy_of((epoch ? *epoch : 0) + 1) == 0 ? even : odd;
  }
};

/// In device memory.
template <class Counters>
struct EpochCounters {
  Counters copies[2];
  std::uint32_t epoch;  ///< of the operation that runs, or else of the next
};

/// What a kernel needs of `Epochs`.
template <class Counters>
struct EpochsView {
  EpochCounters<Counters>* counters = nullptr;
  std::uint64_t* words = nullptr;  ///< of running sums
  std::uint32_t capacity = 0;      ///< words
  std::uint32_t mask = 0;          ///< not below `capacity - 1`; of `swept_word`

  SWIFTGS_HD Counters& copy(std::uint32_t epoch) const { return counters->copies[kernels::copy_of(epoch)]; }
  SWIFTGS_HD Counters& next_copy(std::uint32_t epoch) const { return copy(epoch + 1); }
  LastCounters<Counters> last() const { return {counters->copies, &counters->epoch}; }
};

}  // namespace swiftgs
