// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A stable sort of pairs by the low bits of their keys: a histogram of all digits, then one pass a digit
/// that finds the positions of its pairs while it moves them (Adinets and Merrill 2022, Onesweep).
///
/// The sorts of a frame, of a hundred thousand to some millions of pairs, take as long as their longest chain
/// of waiting: all tiles of a pass are under way at once, and CUB's `DeviceRadixSort` walks back over them
/// one by one and clears memory before each pass. Here a tile waits for seven others and then for groups of
/// them, and nothing is cleared or summed up by a kernel of its own.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

#include <swiftgs/cuda/launch.cuh>
#include <swiftgs/cuda/running_sum.cuh>
#include <swiftgs/cuda/stages.hpp>
#include <swiftgs/cuda/warp.cuh>
#include <swiftgs/error.hpp>

#include "state.hpp"

namespace swiftgs::kernels {

/// With nine bits, blocks rank pairs among twice as many digits. Measured on an H200 when chosen: the sort of
/// garden takes 152 us with three passes of nine bits, for 27 bits of depth, and 148 with four of eight, for
/// 31. That of herz takes 190 and 184.
inline constexpr unsigned digit_bits = 8, digits = RadixCounts::digits;
static_assert(digits == 1u << digit_bits);

/// Which bits of a key a pass sorts by.
struct Digit {
  unsigned shift, bits;

  __device__ unsigned highest() const { return (1u << bits) - 1; }
  template <class Key>
  __device__ unsigned of(Key key) const {
    return unsigned(key >> shift) & highest();
  }
};

struct Pass {
  Digit digit;
  unsigned number;
  bool last;  ///< of its sort
};

/// The passes of a sort by so many bits, each by about as many.
struct Digits {
  unsigned bits, count;

  explicit Digits(unsigned of) : bits(of), count((of + digit_bits - 1) / digit_bits) {}
  __host__ __device__ Digit digit(unsigned pass) const {
    const unsigned begin = bits * pass / count;
    return {begin, bits * (pass + 1) / count - begin};
  }
  Pass pass(unsigned number) const { return {digit(number), number, number + 1 == count}; }
};

inline constexpr unsigned histogram_threads = digits;
inline constexpr unsigned histogram_items = 8;  ///< keys of a thread at a time
/// As many as a device has use for; they share the keys there are.
inline unsigned histogram_blocks(std::size_t n) {
  return std::min(blocks_for(n, histogram_threads * histogram_items), 512u);
}

/// Adds up how often each digit occurs in each pass, and clears the counts of the next sort.
template <class Key>
__global__ void __launch_bounds__(histogram_threads)
    radix_histogram(const Key* keys, const Count count, const Digits passes,
                    const EpochsView<RadixCounts> epochs) {
  await_earlier();
  const std::uint64_t n = count.get();
  const std::uint32_t epoch = read_epoch(epochs);
  // Four times over: neighbouring keys often have the same high digits, and would wait for each other.
  constexpr unsigned copies = 4;
  __shared__ std::uint32_t shared[most_passes][digits][copies];
  for (unsigned p = 0; p < passes.count; ++p)
    for (unsigned c = 0; c < copies; ++c) shared[p][threadIdx.x][c] = 0;
  __syncthreads();

  constexpr unsigned block_items = histogram_threads * histogram_items;
  for (std::uint64_t first = std::uint64_t(blockIdx.x) * block_items; first < n;
       first += std::uint64_t(gridDim.x) * block_items) {
    Key keys_here[histogram_items];
    bool exists[histogram_items];
#pragma unroll
    for (unsigned k = 0; k < histogram_items; ++k) {
      const std::uint64_t at = first + k * histogram_threads + threadIdx.x;
      exists[k] = at < n;
      keys_here[k] = exists[k] ? keys[at] : Key(0);
    }
    for (unsigned p = 0; p < passes.count; ++p) {
      const Digit digit = passes.digit(p);
#pragma unroll
      for (unsigned k = 0; k < histogram_items; ++k)
        if (exists[k]) atomicAdd(&shared[p][digit.of(keys_here[k])][threadIdx.x % copies], 1u);
    }
  }
  __syncthreads();
  for (unsigned p = 0; p < passes.count; ++p) {
    std::uint32_t count = 0;
    for (unsigned c = 0; c < copies; ++c) count += shared[p][threadIdx.x][c];
    if (count != 0) atomicAdd(&epochs.copy(epoch).of_pass[p][threadIdx.x], count);
  }
  if (blockIdx.x == 0)
    for (unsigned p = 0; p < most_passes; ++p) epochs.next_copy(epoch).of_pass[p][threadIdx.x] = 0;
}

/// Tiles of a group. A tile adds up the counts of its group directly, and those before it a group at a time.
inline constexpr unsigned group_tiles = 8;

/// Words of a pass of so many tiles, for each digit: one a tile, and one a group of tiles that is full.
__host__ __device__ constexpr std::uint32_t radix_words(std::uint32_t tiles) {
  return (tiles + tiles / group_tiles) * digits;
}

/// How many pairs of one digit lie in the tiles before a thread block's, one thread per digit. As
/// `RunningSum`, in two levels: in a sort this small all tiles run at once, so none finds a complete sum near
/// by. Blocks start in index order, as there.
class DigitSum {
 public:
  __device__ DigitSum(std::uint64_t* words, std::uint32_t tag)
      : tiles_{words, tag}, groups_{words + std::size_t(gridDim.x) * digits, tag} {}

  /// Tells later tiles how many lie in this one.
  __device__ void add(std::uint32_t count) const { tiles_.publish(blockIdx.x, SumWord::partial, count); }

  /// How many lie in all tiles before this one, which holds `count`.
  __device__ std::uint32_t before(std::uint32_t count) const {
    const std::uint32_t group = blockIdx.x / group_tiles, in_group = blockIdx.x % group_tiles;
    const std::uint32_t here = tiles_.look_back(blockIdx.x, in_group);
    const bool last = in_group == group_tiles - 1;
    if (last) groups_.publish(group, group == 0 ? SumWord::complete : SumWord::partial, here + count);
    if (group == 0) return here;
    const std::uint32_t before = groups_.look_back(group, group) + here;
    if (last) groups_.publish(group, SumWord::complete, before + count);
    return before;
  }

 private:
  /// The words of all tiles, or of all groups.
  struct Row {
    std::uint64_t* words;
    std::uint32_t tag;

    /// Sum of the `count` values before that at `end`, or of those after the nearest complete sum, and that.
    __device__ std::uint32_t look_back(std::uint32_t end, std::uint32_t count) const {
      constexpr unsigned window = 8;
      std::uint32_t sum = 0;
      bool found = false;
      for (std::uint32_t back = 0; back < count && !found; back += window) {
        SumWord seen[window];
#pragma unroll
        for (unsigned k = 0; k < window; ++k)
          if (back + k < count) seen[k] = SumWord::read(word(end - 1 - back - k));
#pragma unroll
        for (unsigned k = 0; k < window; ++k) {
          if (found || back + k >= count) continue;
          while (seen[k].tag() != tag) seen[k] = SumWord::read(word(end - 1 - back - k));
          sum += seen[k].value();
          found = seen[k].known() == SumWord::complete;
        }
      }
      return sum;
    }
    __device__ void publish(std::uint32_t at, std::uint32_t known, std::uint32_t value) const {
      SumWord(tag, known, value).write(word(at));
    }
    __device__ std::uint64_t& word(std::uint32_t at) const {
      return words[std::size_t(at) * digits + threadIdx.x];
    }
  };

  Row tiles_, groups_;
};

/// Measured on an H200 when chosen: a sort of 10 million tile keys takes 182 us with 256 threads, 215 with
/// 512 and 308 with 1,024. Sorts of less than a million take as long with each.
inline constexpr unsigned radix_threads = digits, radix_warps = radix_threads / warp_size;
/// Most pairs of a thread in one pass: as many as fit shared memory with wide keys.
template <class Key>
inline constexpr unsigned most_radix_items = sizeof(Key) == 8 ? 12 : 16;
/// Pairs of a block, a tile.
__host__ __device__ constexpr unsigned radix_tile(unsigned items) { return items * radix_threads; }

/// What the threads of a block tell each other in a pass.
template <class Key, unsigned items>
struct RadixShared {
  std::uint32_t sums_of_warps[2][radix_warps];
  std::uint32_t first[digits];  ///< where the tile's pairs of a digit begin in it
  std::uint32_t moved[digits];  ///< how far they move from there
  union {
    struct {
      std::uint32_t counts[radix_warps][digits];  ///< of each warp, then of the warps before it
      std::uint32_t alike[radix_warps][digits];   ///< lanes that have the digit; zero between two pairs
    } ranks;
    struct {
      std::uint32_t values[radix_tile(items)];
      Key keys[radix_tile(items)];
    } pairs;  ///< in the order of their digits
  };
};

/// Sum over the threads below this one. A barrier of the block.
__device__ inline std::uint32_t sum_below_in_block(std::uint32_t value,
                                                   std::uint32_t (&of_warps)[radix_warps]) {
  const std::uint32_t below = sum_below(value);
  const unsigned warp = threadIdx.x / warp_size;
  if (lane_index() == warp_size - 1) of_warps[warp] = below + value;
  __syncthreads();
  std::uint32_t sum = below;
  for (unsigned w = 0; w < warp; ++w) sum += of_warps[w];
  return sum;
}

/// Ends the epoch of a sort of so many tiles. For all threads of a block.
__device__ inline void end_sort(const EpochsView<RadixCounts>& epochs, std::uint32_t epoch,
                                std::uint32_t tiles) {
  const std::uint32_t swept = swept_word(epoch, digits, epochs.mask), row = swept / digits;
  const bool used = row < tiles || (row >= gridDim.x && row - gridDim.x < tiles / group_tiles);
  if (!used && swept + digits <= epochs.capacity) epochs.words[swept + threadIdx.x] = 0;
  if (threadIdx.x == 0) epochs.counters->epoch = epoch_after(epoch);
}

/// Sorts by one digit: a block a tile, and a thread a digit of it. Without `values`, they are the positions
/// of the keys. Blocks without a tile have nothing to do.
template <class Key, unsigned items>
__global__ void __launch_bounds__(radix_threads)
    radix_pass(const Key* keys, const std::uint32_t* values, Key* sorted_keys, std::uint32_t* sorted_values,
               const Count all, const Pass pass, const EpochsView<RadixCounts> epochs) {
  await_earlier();
  const std::uint32_t epoch = read_epoch(epochs);
  const std::uint64_t n = all.get();
  const std::uint32_t tiles = std::uint32_t((n + radix_tile(items) - 1) / radix_tile(items));
  if (blockIdx.x >= tiles) {
    if (tiles == 0 && pass.last && blockIdx.x == 0) {
      __syncthreads();  // all threads have read the epoch
      end_sort(epochs, epoch, tiles);
    }
    return;
  }
  const Digit digit = pass.digit;
  __shared__ RadixShared<Key, items> shared;
  const unsigned thread = threadIdx.x, warp = thread / warp_size;
  const std::uint64_t tile_first = std::uint64_t(blockIdx.x) * radix_tile(items);
  const unsigned size = unsigned(min(n - tile_first, std::uint64_t(radix_tile(items))));

  // Load: a warp from neighbouring positions. What lies behind the end gets the highest digit, to come last.
  Key key[items];
  std::uint32_t value[items];
  const unsigned first_item = warp * warp_size * items + lane_index();
#pragma unroll
  for (unsigned k = 0; k < items; ++k) {
    const unsigned item = first_item + k * warp_size;
    key[k] = item < size ? keys[tile_first + item] : Key(~Key(0));
  }
#pragma unroll
  for (unsigned k = 0; k < items; ++k) {
    const unsigned item = first_item + k * warp_size;
    value[k] = item >= size ? 0 : values ? values[tile_first + item] : std::uint32_t(tile_first + item);
  }
  // Of both copies, since a load that waits for the epoch would take twice as long.
  const std::uint32_t of_even = epochs.counters->copies[0].of_pass[pass.number][thread],
                      of_odd = epochs.counters->copies[1].of_pass[pass.number][thread];

  // Count the warp's digits. A pair's position is, for now, how many of its digit come before it in the warp.
  // Lanes of one digit find each other by the bits that they set in its word. Measured on an H200 when
  // chosen: the sort of herz takes 136 us so, and 145 by votes on each bit of a digit.
  for (unsigned d = lane_index(); d < digits; d += warp_size)
    shared.ranks.counts[warp][d] = shared.ranks.alike[warp][d] = 0;
  __syncwarp();
  std::uint32_t position[items];
#pragma unroll
  for (unsigned k = 0; k < items; ++k) {
    std::uint32_t &counted = shared.ranks.counts[warp][digit.of(key[k])],
                  &lanes = shared.ranks.alike[warp][digit.of(key[k])];
    atomicOr(&lanes, 1u << lane_index());
    __syncwarp();
    const unsigned alike = lanes;
    const std::uint32_t before = counted;
    __syncwarp();
    if ((alike & lanes_below()) == 0) counted = before + std::uint32_t(__popc(alike)), lanes = 0;
    position[k] = before + std::uint32_t(__popc(alike & lanes_below()));
    __syncwarp();
  }
  __syncthreads();

  // Add up the tile's, and tell later tiles.
  const DigitSum sum(epochs.words, tag_of(epoch, pass.number));
  std::uint32_t count = 0;
#pragma unroll
  for (unsigned w = 0; w < radix_warps; ++w) {
    const std::uint32_t of_warp = shared.ranks.counts[w][thread];
    shared.ranks.counts[w][thread] = count;
    count += of_warp;
  }
  const std::uint32_t added = thread == digit.highest() ? count - (radix_tile(items) - size) : count;
  sum.add(added);
  const std::uint32_t first = sum_below_in_block(count, shared.sums_of_warps[0]);
  const std::uint32_t of_digit = copy_of(epoch) == 0 ? of_even : of_odd;
  const std::uint32_t first_of_all = sum_below_in_block(of_digit, shared.sums_of_warps[1]);
  shared.first[thread] = first;
  __syncthreads();

  // Bring its pairs into the order of their digits.
#pragma unroll
  for (unsigned k = 0; k < items; ++k)
    position[k] += shared.ranks.counts[warp][digit.of(key[k])] + shared.first[digit.of(key[k])];
  __syncthreads();
#pragma unroll
  for (unsigned k = 0; k < items; ++k)
    shared.pairs.keys[position[k]] = key[k], shared.pairs.values[position[k]] = value[k];

  // Move them to where those of earlier tiles end.
  shared.moved[thread] = first_of_all + sum.before(added) - first;
  __syncthreads();
  if (pass.last && blockIdx.x + 1 == tiles) end_sort(epochs, epoch, tiles);
#pragma unroll
  for (unsigned k = 0; k < items; ++k) {
    const unsigned item = k * radix_threads + thread;
    if (item >= size) break;
    const Key moving = shared.pairs.keys[item];
    const std::uint32_t to = item + shared.moved[digit.of(moving)];
    sorted_keys[to] = moving;
    sorted_values[to] = shared.pairs.values[item];
  }
}

/// Tiles that a multiprocessor should have at least.
/// With more, each waits for more others. Measured on an H200 when chosen: the sort of garden takes 154 us
/// with four and 143 with two.
inline constexpr unsigned tiles_at_once = 2;

/// The tiles of a sort: smaller ones where there would be too few for all multiprocessors.
template <class Key>
struct RadixTiles {
  static constexpr unsigned most = most_radix_items<Key>;
  decltype(&radix_pass<Key, most>) pass;
  unsigned count;
  unsigned at_most;  ///< of a sort of no more pairs

  RadixTiles(std::size_t pairs, unsigned least) {
    if (use<most>(pairs) < least && use<most / 2>(pairs) < least) use<most / 4>(pairs);
    at_most = std::max(count, std::min(blocks_for(pairs, radix_tile(most / 4)), 2 * least));
  }

 private:
  template <unsigned items>
  unsigned use(std::size_t pairs) {
    pass = radix_pass<Key, items>;
    return count = blocks_for(pairs, radix_tile(items));
  }
};

/// Throws `CapacityError` where values could not number the pairs.
inline void check_sort(Count n) {
  const std::size_t most = std::numeric_limits<std::uint32_t>::max();
  if (n.most > most) throw CapacityError("pairs in one sort", n.most, most);
}

/// What a sort reads. Without values, they are the positions of the keys.
template <class Key>
struct UnsortedPairs {
  const Key* keys;
  const std::uint32_t* values;
};

/// Starts the kernels of a sort of what `from` has into `pairs`, which may be the same.
template <class Key>
void run_radix_sort(Cuda& cuda, UnsortedPairs<Key> from, Pairs<Cuda, Key>& pairs, Count n, int bits,
                    Epochs<RadixCounts>& epochs) {
  if (n.most == 0 || bits == 0) return;
  check_sort(n);
  const Digits passes{unsigned(bits)};
  const RadixTiles<Key> tiles(n.most, tiles_at_once * unsigned(cuda.multiprocessors()));
  const EpochsView<RadixCounts> view = epochs.begin(cuda, radix_words(tiles.at_most));
  launch_early(cuda, "radix_histogram", radix_histogram<Key>, histogram_blocks(n.most), histogram_threads,
               from.keys, n, passes, view);
  for (unsigned p = 0; p < passes.count; ++p) {
    launch_early(cuda, "radix_pass", tiles.pass, tiles.count, radix_threads, from.keys, from.values,
                 pairs.spare_keys.data(), pairs.spare_values.data(), n, passes.pass(p), view);
    std::swap(pairs.keys, pairs.spare_keys), std::swap(pairs.values, pairs.spare_values);
    from = {pairs.keys.data(), pairs.values.data()};
  }
  epochs.end();
}

/// @see Cuda::sort_pairs
template <class Key>
void run_radix_sort(Cuda& cuda, Pairs<Cuda, Key>& pairs, Count n, int bits, Epochs<RadixCounts>& epochs) {
  run_radix_sort<Key>(cuda, {pairs.keys.data(), pairs.values.data()}, pairs, n, bits, epochs);
}

}  // namespace swiftgs::kernels
