// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// From footprints to tile lists by loops over functors.

#include <cstddef>
#include <cstdint>
#include <tuple>

#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/backend.hpp>
#include <swiftgs/frame/bounds.hpp>
#include <swiftgs/frame/learnt.hpp>
#include <swiftgs/frame/sort.hpp>
#include <swiftgs/frame/splats.hpp>
#include <swiftgs/frame/tiles.hpp>

namespace swiftgs {

/// Numbers of tiles in a given order of the splats, index order when `order` is null.
struct SWIFTGS_API CountTiles {
  Span<const Footprint> footprints;
  const std::uint32_t* order;
  std::uint32_t* counts;

  SWIFTGS_HD void operator()(std::size_t i) const { counts[i] = footprints[order ? order[i] : i].count; }
};

/// Writes one (key, id) pair for each tile of splat `order[i]`, from `offsets[i]` on.
template <class Bounds, class Key>
struct EmitIntersections {
  SortJob job;
  Bounds bounds;
  const std::uint32_t* order;
  const std::uint32_t* offsets;
  Key* keys;
  std::uint32_t* ids;

  SWIFTGS_HD void operator()(std::size_t i) const {
    const std::uint32_t id = order ? order[i] : std::uint32_t(i);
    std::size_t at = offsets[i];
    for_each_tile(job.footprints.each[id], bounds, job.splats.shapes[id], job.grid(id),
                  [&](std::uint32_t tile) {
                    if constexpr (sizeof(Key) == 8)
                      keys[at] = Key(tile) << depth_key_bits | depth_key(job.splats.depths[id]);
                    else
                      keys[at] = tile;
                    ids[at++] = id;
                  });
  }
};

/// Memory that emission works in.
template <class B>
struct IntersectionScratch {
  typename B::template Buffer<std::uint32_t> offsets;

  void reserve(B&, const Reservation& reserved) { offsets.reset_exactly(reserved.capacity.splats); }
  static auto buffers(auto& self) { return std::tie(self.offsets); }
};

/// Emits the intersections of all splats in the given order (index order when `order` is null) and returns
/// how many there are. Keys of 64 bits hold tile above depth, narrower ones the tile alone. Throws
/// `CapacityError` beyond `max_intersections`. Backends overload this.
template <FunctorBackend B, class Bounds, class Key>
Count emit_intersections(B& b, const SortJob& job, const Bounds& bounds, const std::uint32_t* order,
                         IntersectionScratch<B>& scratch, Pairs<B, Key>& intersections) {
  check_footprints(job);
  const std::size_t splats = job.splats.size();
  check_intersections(job.footprints.intersections.most);
  scratch.offsets.reset(splats);
  std::uint32_t* const offsets = scratch.offsets.data();
  b.for_each(splats, CountTiles{job.footprints.each, order, offsets});
  const std::uint64_t total = b.exclusive_scan(Span{offsets, splats});
  check_sum(job.footprints.intersections.most, total);
  intersections.reset(std::size_t(total));
  b.for_each(splats, EmitIntersections<Bounds, Key>{job, bounds, order, offsets, intersections.keys.data(),
                                                    intersections.values.data()});
  return std::size_t(total);
}

/// Memory that grouping works in.
template <class B>
struct GroupScratch : KeyedIntersections<B, std::uint32_t> {};

/// Lists for every tile the splats that may touch it, in the given order: emits the intersections in that
/// order and sorts them by tile alone, stably and by as few bits as the tiles need. Backends overload this.
template <FunctorBackend B, class Bounds>
void group_by_tile(B& b, const SortJob& job, const Bounds& bounds, const std::uint32_t* order,
                   GroupScratch<B>& scratch, TileLists<B>& lists) {
  const Count count = emit_intersections(b, job, bounds, order, scratch.emission, scratch.intersections);
  b.sort_pairs(scratch.intersections, count, job.footprints.views.tiles.key_bits());
  finish_lists(b, job.footprints, count, 0, scratch.intersections, lists);
}

}  // namespace swiftgs
