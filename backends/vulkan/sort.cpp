// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
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

std::size_t parts_of(const Commands& commands, std::size_t pairs) {
  const std::size_t part = commands.sort_part(pairs);
  return (pairs + part - 1) / part;
}

void take_memory(Vulkan& b, const Commands& commands, std::size_t pairs) {
  const std::size_t numbers = sort_digits * (parts_of(commands, pairs) + 1);
  if (numbers > 0xffffffff)
    throw CapacityError("pairs to sort", pairs, (0xffffffff / sort_digits - 1) * commands.sort_part(pairs));
  b.state().numbers.reset(numbers);
}

/// Sorts stably by the digit at `bit`.
void sort_digit(Vulkan& b, Commands& commands, const SortedPairs& pairs, Count n, int bit, int bits) {
  std::uint32_t* const totals = b.state().numbers.data();
  std::uint32_t* const numbers = totals + sort_digits;
  const std::size_t count = sort_digits * parts_of(commands, n.most), words = pairs.words * n.most;
  const std::uint32_t mask = (1u << std::min(digit_bits, bits - bit)) - 1;
  const Commands::Shape shape = commands.over(n, Groups::sort);
  commands.run(Kernel::sort_count, {pairs.words, commands.sort_each(n.most)},
               Push(reads(pairs.keys, words), writes(numbers, count), n, std::uint32_t(bit), mask), shape);
  // Small subgroups are software's, which is slow at barriers.
  commands.run(Kernel::sort_scan, {},
               Push(writes(numbers, count), writes(totals, sort_digits), n, commands.sort_part(n.most)),
               {.columns = sort_digits, .threads = commands.subgroup() < 32 ? commands.subgroup() : 256});
  commands.run(Kernel::sort_move, {pairs.words, commands.sort_each(n.most)},
               Push(reads(pairs.keys, words), reads(numbers, count), reads(totals, sort_digits),
                    reads(pairs.values, n.most), writes(pairs.keys_to, words),
                    writes(pairs.values_to, n.most), n, std::uint32_t(bit), mask),
               shape);
  commands.run_beside();
}

template <class Key>
void sort_pairs(Vulkan& b, Pairs<Vulkan, Key>& pairs, Count n, int bits) {
  if (n.most == 0 || bits == 0) return;
  Commands commands(b);
  take_memory(b, commands, n.most);
  for (int bit = 0; bit < bits; bit += digit_bits) {
    const Keys keys(pairs.keys.data()), spare(pairs.spare_keys.data());
    sort_digit(b, commands,
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
  vulkan::take_memory(b, commands, n.most);
  // The first pass reads the depths, and positions in place of values.
  const void* const depths = splats.depths.data;
  const std::uint32_t *keys = static_cast<const std::uint32_t*>(depths), *values = nullptr;
  for (int bit = 0; bit < depth_key_bits; bit += vulkan::digit_bits) {
    vulkan::sort_digit(b, commands, {keys, values, pairs.spare_keys.data(), pairs.spare_values.data(), 1}, n,
                       bit, depth_key_bits);
    std::swap(pairs.keys, pairs.spare_keys), std::swap(pairs.values, pairs.spare_values);
    keys = pairs.keys.data(), values = pairs.values.data();
  }
  commands.finish();
  return pairs.values.data();
}

}  // namespace swiftgs
