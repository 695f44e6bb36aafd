// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

#include <swiftgs/frame/sort.hpp>

namespace swiftgs {

/// One stable sort of all intersections by 64-bit keys, tile above depth bits: the sort of INRIA's rasterizer
/// and gsplat.
struct StandardSort {
  static constexpr std::string_view name = "standard";

  template <class B>
  using Scratch = KeyedIntersections<B, std::uint64_t>;

  template <class B, class Bounds>
  void build(B& b, const SortJob& job, const Bounds& bounds, Scratch<B>& scratch, TileLists<B>& lists) {
    const Count count = emit_intersections(b, job, bounds, nullptr, scratch.emission, scratch.intersections);
    b.sort_pairs(scratch.intersections, count, job.footprints.views.tiles.key_bits() + depth_key_bits);
    finish_lists(b, job.footprints, count, depth_key_bits, scratch.intersections, lists);
  }
};

}  // namespace swiftgs
