// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <swiftgs/sort/sort.hpp>

namespace swiftgs {

/// One stable sort of all instances by 64-bit keys, tile above depth bits: the sort of INRIA's rasterizer and
/// gsplat.
struct StandardSort {
  static constexpr std::string_view name = "standard";
  using Loops = TypeList<>;

  template <class B>
  struct Scratch {
    InstanceScratch<B> emission;
    Pairs<B, std::uint64_t> instances;

    std::size_t bytes() const { return bytes_of(emission, instances); }
  };

  template <class B, class Bounds>
  void build(B& b, const SortJob<Bounds>& job, const Bounds& bounds, Scratch<B>& scratch,
             TileLists<B>& lists) {
    const Count count = emit_instances(b, job, bounds, nullptr, scratch.emission, scratch.instances);
    b.sort_pairs(scratch.instances, count, job.footprints.tiles.key_bits() + depth_key_bits);
    finish_lists(b, job.footprints, count, depth_key_bits, scratch.instances, lists);
  }
};

}  // namespace swiftgs
