// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <tuple>
#include <utility>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/backend.hpp>
#include <swiftgs/frame/bounds.hpp>
#include <swiftgs/frame/frame_plan.hpp>
#include <swiftgs/frame/splats.hpp>
#include <swiftgs/frame/tiles.hpp>

namespace swiftgs {

/// What a sort turns into tile lists, of the views of the footprints.
struct SortJob {
  SplatsView splats;
  FootprintsView footprints;  ///< of these splats
  FrameKey key;
  FrameUse use = FrameUse::drawn;

  /// Of the view that splat i is of.
  SWIFTGS_HD const TileGrid& grid(std::size_t i) const {
    return footprints.views.reachable()[splats.view(i)].grid;
  }
};

/// Throws `InvalidArgument` if the footprints of `job` are of another number of splats.
inline void check_footprints(const SortJob& job) {
  if (job.footprints.each.size != job.splats.size())
    detail::refuse("sort: there are footprints of ", job.footprints.each.size, " splats, expected those of ",
                   job.splats.size());
}

/// Policy `S` builds tile lists on backend `B` within bounds `Bounds`: for every tile the ids of the splats
/// that may touch it, nearest first, equal depths by ascending index. An object of `S` may keep what it
/// learnt from earlier frames. `Scratch<B>` is the memory that it works in: it lists its `buffers` or has a
/// member `bytes`. Its member `reserve(b, reserved)` takes the memory of such frames on hosts; without it,
/// recorded frames there may allocate.
template <class S, class B, class Bounds>
concept SortsOn = BackendPolicy<B> && BoundsPolicy<Bounds> && HasBytes<typename S::template Scratch<B>> &&
    std::default_initializable<typename S::template Scratch<B>> &&
    std::movable<typename S::template Scratch<B>> &&
    requires(S sort, B& b, const SortJob& job, const Bounds& bounds, typename S::template Scratch<B>& scratch,
             TileLists<B>& lists) {
  { S::name } -> std::convertible_to<std::string_view>;
  sort.build(b, job, bounds, scratch, lists);
};

/// Marks where each tile's intersections begin and end in keys sorted by tile, from the keys [i, i + 1) times
/// `keys_each`. Tiles without intersections keep {0, 0}.
template <class Key>
struct SWIFTGS_API FindRanges {
  static constexpr std::size_t keys_each = 8;

  const Key* keys;
  Count intersections;
  int tile_shift;
  Span<TileRange> ranges;

  SWIFTGS_HD void operator()(std::size_t i) const {
    const std::size_t begin = i * keys_each, count = intersections.get();
    if (begin >= count) return;
    const std::size_t end = count - begin < keys_each ? count : begin + keys_each;
    std::size_t before = begin == 0 ? ranges.size : tile(begin - 1);
    for (std::size_t k = begin; k < end; ++k) {
      const std::size_t here = tile(k);
      if (here == before) continue;
      // If counting and emission disagree, keys may name tiles outside the grid.
      if (before < ranges.size) ranges[before].end = std::uint32_t(k);
      if (here < ranges.size) ranges[here].begin = std::uint32_t(k);
      before = here;
    }
    if (end == count && before < ranges.size) ranges[before].end = std::uint32_t(count);
  }

 private:
  SWIFTGS_HD std::size_t tile(std::size_t k) const { return std::size_t(keys[k] >> tile_shift); }
};

/// Empties a range. In a frame that overflowed it becomes one that rasterizers draw nothing for.
struct SWIFTGS_API ClearRanges {
  TileRange* ranges;
  const std::uint64_t* overflowed;  ///< null: the frame has not
  SWIFTGS_HD void operator()(std::size_t i) const {
    ranges[i] = overflowed && *overflowed != 0 ? TileRange::undrawn() : TileRange{};
  }
};

/// Memory that emission and grouping by tile work in.
template <class B>
struct IntersectionScratch;
template <class B>
struct GroupScratch;

/// Intersections with keys to sort them by, and the memory that their emission works in.
template <class B, class Key>
struct KeyedIntersections {
  IntersectionScratch<B> emission;
  Pairs<B, Key> intersections;

  void reserve(B& b, const Reservation& reserved) {
    reserve_parts(b, reserved, emission);
    intersections.reset_exactly(reserved.capacity.intersections);
    reserve_sort(b, reserved.capacity.intersections);
  }
  static auto buffers(auto& self) { return std::tie(self.emission, self.intersections); }
};

/// Throws `InvalidArgument` if footprints do not have as many intersections as they say.
inline void check_sum(std::uint64_t said, std::uint64_t sum) {
  if (said != sum)
    detail::refuse("sort: the footprints hold ", sum, " intersections, expected those that they say, ", said);
}

/// Moves the sorted intersections to `lists`. The next frame reuses the old ids, and allocates nothing if it
/// is no larger.
template <FunctorBackend B, class Key>
void finish_lists(B& b, const FootprintsView& footprints, Count count, int tile_shift,
                  Pairs<B, Key>& intersections, TileLists<B>& lists) {
  const std::size_t tiles = footprints.views.tiles.size();
  lists.tiles = lists.intersections = 0;
  lists.ranges.reset(tiles);
  b.for_each(tiles, ClearRanges{lists.ranges.data(), footprints.overflowed});
  using Find = FindRanges<Key>;
  b.for_each((count.most + Find::keys_each - 1) / Find::keys_each,
             Find{intersections.keys.data(), count, tile_shift, lists.ranges.span()});
  std::swap(lists.ids, intersections.values);
  lists.tiles = tiles, lists.intersections = count.most;
  intersections.values.reset(count.most);
}

}  // namespace swiftgs
