// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <tuple>

#include <swiftgs/api.hpp>
#include <swiftgs/sort/sort.hpp>

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

/// Early sorting (SwiftGS, section 4.1): sort the visible splats by depth once, emit their instances in that
/// order, and sort those by tile alone. Depth is looked at once a splat instead of once an instance.
struct EarlySort {
  static constexpr std::string_view name = "early";
  using Loops = TypeList<DepthPair>;

  template <class B>
  struct Scratch {
    Pairs<B, std::uint32_t> depths;
    GroupScratch<B> group;

    void reserve(B& b, const FrameRoom& room) {
      depths.reset_exactly(room.capacity.splats);
      reserve_sort(b, room.capacity.splats);
      reserve_parts(b, room, group);
    }
    static auto buffers(auto& self) { return std::tie(self.depths, self.group); }
  };

  template <class B, class Bounds>
  void build(B& b, const SortJob<Bounds>& job, const Bounds& bounds, Scratch<B>& scratch,
             TileLists<B>& lists) {
    const Count splats = job.splats.count();
    scratch.depths.reset(splats.most);
    b.for_each(splats,
               DepthPair{job.splats.depths.data, scratch.depths.keys.data(), scratch.depths.values.data()});
    b.sort_pairs(scratch.depths, splats, depth_key_bits);

    group_by_tile(b, job, bounds, scratch.depths.values.data(), scratch.group, lists);
  }
};

}  // namespace swiftgs
