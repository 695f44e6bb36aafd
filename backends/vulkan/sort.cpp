// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>

#include <swiftgs/error.hpp>
#include <swiftgs/vulkan/stages.hpp>

#include "commands.hpp"

namespace swiftgs {

namespace vulkan {
namespace {

constexpr int digit_bits = 8;
static_assert(1 << digit_bits == sort_digits);

/// Keys of `words` words each, and values; null values stand for positions.
struct SortedPairs {
  const std::uint32_t* keys;
  const std::uint32_t* values;
  std::uint32_t* keys_to;
  std::uint32_t* values_to;
  std::uint32_t words;
};

/// What the kernels of a sort count by digit: pairs of each part, and of each run of parts. The sums of runs
/// are in two sets used alternately: a pass fills one and clears the other for the next.
struct Counts {
  Span<std::uint32_t> numbers;
  std::array<Span<std::uint32_t>, 2> sums;
  std::uint32_t run;  ///< parts: about the root of their number, so that a part adds up few numbers

  /// Takes memory for `pairs`, and clears the first set.
  Counts(Vulkan& b, Commands& commands, std::size_t pairs) {
    const std::size_t part = commands.sort_part(pairs), parts = (pairs + part - 1) / part;
    run = std::uint32_t(1) << std::bit_width(parts) / 2;
    const std::size_t of_runs = sort_digits * ((parts + run - 1) / run), of_parts = sort_digits * parts;
    if (of_parts + 2 * of_runs > 0x7fffffff)
      throw CapacityError("pairs to sort", pairs, 0x7fffffff / (3 * sort_digits) * part);
    VulkanBuffer<std::uint32_t>& buffer = b.state().numbers;
    buffer.reset(of_parts + 2 * of_runs);
    std::uint32_t* const data = buffer.data();
    sums = {{{data, of_runs}, {data + of_runs, of_runs}}};
    numbers = {data + 2 * of_runs, of_parts};
    commands.fill(data, of_runs, 0);
  }
};

/// Sorts stably by the digit at `bit`.
void sort_digit(Commands& commands, const Counts& counts, const SortedPairs& pairs, Count n, int bit,
                int bits) {
  const std::size_t words = pairs.words * n.most, set = std::size_t(bit / digit_bits % 2);
  const Span<std::uint32_t> numbers = counts.numbers, sums = counts.sums[set], next = counts.sums[1 - set];
  const std::uint32_t mask = (1u << std::min(digit_bits, bits - bit)) - 1;
  const Commands::Shape shape = commands.over(n, Groups::sort);
  commands.run(
      Kernel::sort_count, {pairs.words, commands.sort_each(n.most)},
      Push(reads(pairs.keys, words), writes(numbers.data, numbers.size), writes(sums.data, sums.size),
           writes(next.data, next.size), n, counts.run, std::uint32_t(bit), mask),
      shape);
  commands.run(Kernel::sort_move, {pairs.words, commands.sort_each(n.most)},
               Push(reads(pairs.keys, words), reads(numbers.data, numbers.size), reads(sums.data, sums.size),
                    reads(pairs.values, n.most), writes(pairs.keys_to, words),
                    writes(pairs.values_to, n.most), n, counts.run, std::uint32_t(bit), mask),
               shape);
  commands.run_beside();
}

template <class Key>
void sort_pairs(Vulkan& b, Pairs<Vulkan, Key>& pairs, Count n, int bits) {
  if (n.most == 0 || bits == 0) return;
  Commands commands(b);
  const Counts counts(b, commands, n.most);
  for (int bit = 0; bit < bits; bit += digit_bits) {
    const Keys keys(pairs.keys.data()), spare(pairs.spare_keys.data());
    sort_digit(commands, counts,
               {keys.words, pairs.values.data(), spare.words, pairs.spare_values.data(), keys.each}, n, bit,
               bits);
    std::swap(pairs.keys, pairs.spare_keys), std::swap(pairs.values, pairs.spare_values);
  }
  commands.finish();
}

}  // namespace
}  // namespace vulkan

void Vulkan::sort_pairs(Pairs<Vulkan, std::uint32_t>& pairs, Count n, int bits) {
  vulkan::sort_pairs(*this, pairs, n, bits);
}
void Vulkan::sort_pairs(Pairs<Vulkan, std::uint64_t>& pairs, Count n, int bits) {
  vulkan::sort_pairs(*this, pairs, n, bits);
}

const std::uint32_t* order_by_depth(Vulkan& b, const SplatsView& splats, DepthOrderScratch<Vulkan>& scratch) {
  const Count n = splats.count();
  Pairs<Vulkan, std::uint32_t>& pairs = scratch.pairs;
  pairs.reset(n.most);
  if (n.most == 0) return pairs.values.data();
  vulkan::Commands commands(b);
  const vulkan::Counts counts(b, commands, n.most);
  // The first pass reads the depths, and positions in place of values.
  const void* const depths = splats.depths.data;
  const std::uint32_t *keys = static_cast<const std::uint32_t*>(depths), *values = nullptr;
  for (int bit = 0; bit < depth_key_bits; bit += vulkan::digit_bits) {
    vulkan::sort_digit(commands, counts,
                       {keys, values, pairs.spare_keys.data(), pairs.spare_values.data(), 1}, n, bit,
                       depth_key_bits);
    std::swap(pairs.keys, pairs.spare_keys), std::swap(pairs.values, pairs.spare_values);
    keys = pairs.keys.data(), values = pairs.values.data();
  }
  commands.finish();
  return pairs.values.data();
}

}  // namespace swiftgs
