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
constexpr std::size_t digits = std::size_t(1) << digit_bits;

/// Keys of `words` words each, and values; null values stand for positions.
struct SortedPairs {
  const void* keys;
  const std::uint32_t* values;
  void* keys_to;
  std::uint32_t* values_to;
  std::uint32_t words;
};

/// Sums over the numbers of all digits in all parts.
void take_memory(Vulkan& b, Commands& commands, std::size_t pairs) {
  const std::size_t part = 16 * commands.sort_threads(), parts = (pairs + part - 1) / part;
  if (parts * digits > 0xffffffff) throw CapacityError("pairs to sort", pairs, 0xffffffff / digits * part);
  b.state().places.reset(parts * digits), commands.reserve_scan(parts * digits);
}

/// Sorts stably by the digit at `bit`.
void sort_digit(Vulkan& b, Commands& commands, const SortedPairs& pairs, Count n, int bit, int bits) {
  const std::uint32_t threads = commands.sort_threads();
  const std::size_t part = 16 * std::size_t(threads), parts = (n.most + part - 1) / part;
  std::uint32_t* const places = b.state().places.data();
  const std::uint32_t mask = (1u << std::min(digit_bits, bits - bit)) - 1;
  const Push push(pairs.keys, pairs.values, pairs.keys_to, pairs.values_to, places, n, std::uint32_t(bit),
                  mask, std::uint32_t(parts));
  const Commands::Shape shape = Commands::Shape::of(n.most, part, threads);
  const std::size_t key_bytes = 4 * pairs.words * n.most, bytes = 4 * n.most;
  const Access number = reads(n.exact, n.exact ? 4 : 0);
  commands.run(Kernel::sort_count, {pairs.words}, push, shape,
               {reads(pairs.keys, key_bytes), number, writes(places, 4 * parts * digits)});
  commands.scan(places, parts * digits);
  commands.run(
      Kernel::sort_move, {pairs.words}, push, shape,
      {reads(pairs.keys, key_bytes), reads(pairs.values, pairs.values ? bytes : 0), number,
       reads(places, 4 * parts * digits), writes(pairs.keys_to, key_bytes), writes(pairs.values_to, bytes)});
}

template <class Key>
void sort_pairs(Vulkan& b, Pairs<Vulkan, Key>& pairs, Count n, int bits) {
  if (n.most == 0 || bits == 0) return;
  Commands commands(b);
  take_memory(b, commands, n.most);
  for (int bit = 0; bit < bits; bit += digit_bits) {
    sort_digit(b, commands,
               {pairs.keys.data(), pairs.values.data(), pairs.spare_keys.data(), pairs.spare_values.data(),
                sizeof(Key) / 4},
               n, bit, bits);
    std::swap(pairs.keys, pairs.spare_keys), std::swap(pairs.values, pairs.spare_values);
  }
  commands.submit();
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
  const void* keys = splats.depths.data;
  const std::uint32_t* values = nullptr;
  for (int bit = 0; bit < depth_key_bits; bit += vulkan::digit_bits) {
    vulkan::sort_digit(b, commands, {keys, values, pairs.spare_keys.data(), pairs.spare_values.data(), 1}, n,
                       bit, depth_key_bits);
    std::swap(pairs.keys, pairs.spare_keys), std::swap(pairs.values, pairs.spare_values);
    keys = pairs.keys.data(), values = pairs.values.data();
  }
  commands.submit();
  return pairs.values.data();
}

}  // namespace swiftgs
