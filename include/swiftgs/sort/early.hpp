// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <tuple>

#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/sort.hpp>

namespace swiftgs {

/// Key and index of splat i before the depth sort.
struct SWIFTGS_API DepthPair {
  const float* depths;
  std::uint32_t* keys;
  std::uint32_t* ids;

  SWIFTGS_HD void operator()(std::size_t i) const {
    keys[i] = depth_key(depths[i]);
    ids[i] = std::uint32_t(i);
  }
};

/// Memory of the order of splats by depth.
template <class B>
struct DepthOrderScratch {
  Pairs<B, std::uint32_t> pairs;  ///< depth keys, indices

  void reserve(B& b, const Reservation& reserved) {
    pairs.reset_exactly(reserved.capacity.splats);
    reserve_sort(b, reserved.capacity.splats);
  }
  static auto buffers(auto& self) { return std::tie(self.pairs); }
};

/// Indices of the splats, nearest first, equal depths in index order; they lie in `scratch`. Backends
/// overload this.
template <FunctorBackend B>
const std::uint32_t* order_by_depth(B& b, const SplatsView& splats, DepthOrderScratch<B>& scratch) {
  const Count count = splats.count();
  Pairs<B, std::uint32_t>& pairs = scratch.pairs;
  pairs.reset(count.most);
  b.for_each(count, DepthPair{splats.depths.data, pairs.keys.data(), pairs.values.data()});
  b.sort_pairs(pairs, count, depth_key_bits);
  return pairs.values.data();
}

/// Early sorting (SwiftGS, section 4.1): sort the visible splats by depth once, emit their intersections in
/// that order, and sort those by tile alone. Depth is looked at once a splat instead of once an intersection.
struct EarlySort {
  static constexpr std::string_view name = "early";

  template <class B>
  struct Scratch {
    DepthOrderScratch<B> depths;
    GroupScratch<B> group;

    void reserve(B& b, const Reservation& reserved) { reserve_parts(b, reserved, depths, group); }
    static auto buffers(auto& self) { return std::tie(self.depths, self.group); }
  };

  template <class B, class Bounds>
  void build(B& b, const SortJob& job, const Bounds& bounds, Scratch<B>& scratch, TileLists<B>& lists) {
    const std::uint32_t* const order = order_by_depth(b, job.splats, scratch.depths);
    group_by_tile(b, job, bounds, order, scratch.group, lists);
  }
};

}  // namespace swiftgs
