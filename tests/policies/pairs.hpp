// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

#include <swiftgs/frame/backend.hpp>

#include "policies/random_splats.hpp"
#include "policies/tile_lists.hpp"

namespace swiftgs::test {

/// What stable sorting by the low `bits` bits means.
template <class Key>
void stable_sort_pairs(std::vector<Key>& keys, std::vector<std::uint32_t>& values, int bits) {
  const Key mask = bits == 0 ? Key(0) : Key(Key(~Key(0)) >> (8 * int(sizeof(Key)) - bits));
  std::vector<std::size_t> order(keys.size());
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return (keys[a] & mask) < (keys[b] & mask); });
  const std::vector<Key> old_keys = keys;
  const std::vector<std::uint32_t> old_values = values;
  for (std::size_t i = 0; i < order.size(); ++i)
    keys[i] = old_keys[order[i]], values[i] = old_values[order[i]];
}

/// Random keys of all bits: those above the sorted ones are garbage that must not matter.
template <class Key>
std::vector<Key> random_keys(std::size_t n, std::uint64_t seed) {
  Random random(seed);
  std::vector<Key> keys(n);
  for (Key& key : keys) key = Key(random.bits() >> 3);
  return keys;
}

/// Whether `backend` sorts `keys` exactly as a stable sort does, the values numbered in order.
template <class B, class Key>
bool sorts(B& backend, std::vector<Key> keys, int bits) {
  std::vector<std::uint32_t> values(keys.size());
  std::iota(values.begin(), values.end(), 7u);
  Pairs<B, Key> pairs;
  pairs.keys = to_backend(backend, keys), pairs.values = to_backend(backend, values);
  pairs.spare_keys.reset(keys.size()), pairs.spare_values.reset(keys.size());
  backend.sort_pairs(pairs, keys.size(), bits);
  stable_sort_pairs(keys, values, bits);
  return to_host(backend, Span<const Key>{pairs.keys.data(), keys.size()}) == keys &&
         to_host(backend, Span<const std::uint32_t>{pairs.values.data(), keys.size()}) == values;
}

}  // namespace swiftgs::test
