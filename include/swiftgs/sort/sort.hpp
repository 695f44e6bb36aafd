// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include <swiftgs/api.hpp>
#include <swiftgs/backend.hpp>
#include <swiftgs/bounds/bounds.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/footprint.hpp>
#include <swiftgs/splats.hpp>
#include <swiftgs/tiles.hpp>

namespace swiftgs {

/// Which scene at which image size: what a choice of sort strategy holds for.
struct FrameKey {
  std::uint64_t scene = 0;  ///< `SceneView::identity`
  std::size_t gaussians = 0;
  int width = 0, height = 0;

  bool operator==(const FrameKey&) const = default;
};

/// What a sort turns into tile lists within `Bounds`.
template <BoundsPolicy Bounds>
struct SortJob {
  SplatsView splats;  ///< Read only `depth` of colours; `rgb` may not be written yet.
  TileGrid grid;
  FrameKey key;
  FootprintsView<Bounds> footprints{};  ///< of these splats on this grid; none for splats of your own
};

/// Throws `std::invalid_argument` if the footprints of `job` are of another grid or another number of splats.
template <BoundsPolicy Bounds>
void check_footprints(const SortJob<Bounds>& job) {
  const auto size = [](TileGrid grid) {
    return std::to_string(grid.columns) + " x " + std::to_string(grid.rows) + " tiles";
  };
  const FootprintsView<Bounds>& footprints = job.footprints;
  if (footprints.grid != TileGrid{} && footprints.grid != job.grid)
    throw std::invalid_argument("sort: the splats were projected for " + size(footprints.grid) +
                                ", expected the grid of the sort, " + size(job.grid));
  if (footprints.each.data && footprints.each.size != job.splats.size())
    throw std::invalid_argument("sort: there are footprints of " + std::to_string(footprints.each.size) +
                                " splats, expected those of " + std::to_string(job.splats.size()));
}

/// Policy `S` builds tile lists on backend `B` within bounds `Bounds`: for every tile the ids of the splats
/// that may touch it, nearest first, equal depths by ascending index. An object of `S` may keep what it
/// learnt from earlier frames; `Scratch<B>` is the memory that it works in, `bytes()` of it.
template <class S, class B, class Bounds>
concept SortsOn = BackendPolicy<B> && BoundsPolicy<Bounds> &&
    requires(S sort, B& b, const SortJob<Bounds>& job, const Bounds& bounds,
             typename S::template Scratch<B>& scratch, TileLists<B>& lists) {
  { S::name } -> std::convertible_to<std::string_view>;
  { scratch.bytes() } -> std::same_as<std::size_t>;
  sort.build(b, job, bounds, scratch, lists);
};

/// Sum of the runs of tiles that `shape` may touch.
template <BoundsPolicy Bounds>
SWIFTGS_HD std::uint32_t count_tiles(const Bounds& bounds, const SplatShape& shape, TileGrid grid) {
  const TileRect rect = bounds.rect(shape, grid);
  if (rect.columns.size() == 0) return 0;
  std::uint32_t count = 0;
  for (int row = rect.rows.begin; row < rect.rows.end; ++row)
    count += std::uint32_t(bounds.row(shape, rect, row).size());
  return count;
}

/// Counts the tiles of splat `order[i]`, or of splat i where there is no order.
template <class Bounds>
struct CountTiles {
  SplatsView splats;
  const std::uint32_t* order;
  TileGrid grid;
  Bounds bounds;
  std::uint32_t* counts;

  SWIFTGS_HD void operator()(std::size_t i) const {
    counts[i] = count_tiles(bounds, splats.shapes[order ? order[i] : i], grid);
  }
};

/// Writes one (key, id) pair for each tile that splat `order[i]` may touch, from `offsets[i]` on.
///
/// Code that counts and code that emits may round differently, where a compiler is free to. Emission
/// therefore fills exactly what was counted: it ends there, and gives what is left to other tiles of the
/// grid, where the rasterizer finds that the splat shows nothing. No tile has a splat twice.
template <class Bounds, class Key>
struct EmitInstances {
  SplatsView splats;
  const std::uint32_t* order;
  TileGrid grid;
  Bounds bounds;
  Span<const std::uint32_t> offsets;
  std::size_t total;
  Key* keys;
  std::uint32_t* ids;

  SWIFTGS_HD void operator()(std::size_t i) const {
    const std::uint32_t id = order ? order[i] : std::uint32_t(i);
    const SplatShape& shape = splats.shapes[id];
    std::size_t at = offsets[i];
    const std::size_t begin = at, end = i + 1 < offsets.size ? offsets[i + 1] : total;
    if (at == end) return;
    const auto emit = [&](std::uint32_t tile) { keys[at] = key(tile, id), ids[at] = id, ++at; };
    const TileRect rect = bounds.rect(shape, grid);
    for (int row = rect.rows.begin; row < rect.rows.end && rect.columns.size() != 0; ++row) {
      const TileRun run = bounds.row(shape, rect, row);
      for (int column = run.begin; column < run.end && at < end; ++column)
        emit(std::uint32_t(row * grid.columns + column));
    }
    // Tiles that it has were written in ascending order.
    std::size_t named = begin;
    const std::size_t all_named = at;
    for (std::uint32_t tile = 0; at < end; ++tile) {
      if (named < all_named && tile_of(keys[named]) == tile)
        ++named;
      else
        emit(tile);
    }
  }

 private:
  SWIFTGS_HD static std::uint32_t tile_of(Key key) {
    return std::uint32_t(sizeof(Key) == 8 ? key >> (sizeof(Key) == 8 ? depth_key_bits : 0) : key);
  }
  SWIFTGS_HD Key key(std::uint32_t tile, std::uint32_t id) const {
    if constexpr (sizeof(Key) == 8)
      return Key(tile) << depth_key_bits | depth_key(splats.colours[id].depth);
    else
      return (void)id, tile;
  }
};

/// Marks where each tile's instances begin and end in keys sorted by tile, from the keys [i, i + 1) times
/// `keys_each`. Tiles without instances keep {0, 0}.
template <class Key>
struct SWIFTGS_API FindRanges {
  static constexpr std::size_t keys_each = 8;

  const Key* keys;
  std::size_t count;
  int tile_shift;
  Span<TileRange> ranges;

  SWIFTGS_HD void operator()(std::size_t i) const {
    const std::size_t begin = i * keys_each, end = count - begin < keys_each ? count : begin + keys_each;
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

/// Empties a range.
struct SWIFTGS_API ClearRanges {
  TileRange* ranges;
  SWIFTGS_HD void operator()(std::size_t i) const { ranges[i] = {}; }
};

/// Throws `CapacityError` where a frame has more instances than a tile list can index.
inline void check_instances(std::uint64_t total) {
  if (total > max_instances) throw CapacityError("instances in one frame", total, max_instances);
}

/// Memory that emission works in.
template <class B>
struct InstanceScratch {
  typename B::template Buffer<std::uint32_t> offsets;

  std::size_t bytes() const { return offsets.bytes(); }
};

/// Emits the instances of all splats in the given order (index order when `order` is null) and returns their
/// number. Keys of 64 bits hold tile above depth, narrower ones the tile alone. Throws `CapacityError`
/// beyond `max_instances`.
/// Backends overload this for bounds that they have kernels for.
template <class B, class Bounds, class Key>
std::size_t emit_instances(B& b, const SortJob<Bounds>& job, const Bounds& bounds, const std::uint32_t* order,
                           InstanceScratch<B>& scratch, Pairs<B, Key>& instances) {
  check_footprints(job);
  const std::size_t splats = job.splats.size();
  auto& offsets = scratch.offsets;
  offsets.reset(splats);
  b.for_each(splats, CountTiles<Bounds>{job.splats, order, job.grid, bounds, offsets.data()});
  const std::uint64_t total = b.exclusive_scan(Span{offsets.data(), splats});
  check_instances(total);
  instances.reset(std::size_t(total));
  b.for_each(splats, EmitInstances<Bounds, Key>{job.splats,
                                                order,
                                                job.grid,
                                                bounds,
                                                {offsets.data(), splats},
                                                std::size_t(total),
                                                instances.keys.data(),
                                                instances.values.data()});
  return std::size_t(total);
}

/// Hands the sorted instances over to `lists`; the old ids become room for the next frame, which allocates
/// nothing if it is no larger.
template <class B, class Key>
void finish_lists(B& b, TileGrid grid, std::size_t count, int tile_shift, Pairs<B, Key>& instances,
                  TileLists<B>& lists) {
  const std::size_t tiles = grid.size();
  lists.tiles = lists.instances = 0;
  lists.ranges.reset(tiles);
  b.for_each(tiles, ClearRanges{lists.ranges.data()});
  using Find = FindRanges<Key>;
  b.for_each((count + Find::keys_each - 1) / Find::keys_each,
             Find{instances.keys.data(), count, tile_shift, lists.ranges.span()});
  std::swap(lists.ids, instances.values);
  lists.tiles = tiles, lists.instances = count;
  instances.values.reset(count);
}

/// Memory that grouping works in.
template <class B>
struct GroupScratch {
  InstanceScratch<B> emission;
  Pairs<B, std::uint32_t> instances;

  std::size_t bytes() const { return bytes_of(emission, instances); }
};

/// Lists for every tile the splats that may touch it, in the given order: emits the instances in that order
/// and sorts them by tile alone, stably and by as few bits as the grid needs. Backends overload this for
/// bounds that they have kernels for.
template <class B, class Bounds>
void group_by_tile(B& b, const SortJob<Bounds>& job, const Bounds& bounds, const std::uint32_t* order,
                   GroupScratch<B>& scratch, TileLists<B>& lists) {
  const std::size_t count = emit_instances(b, job, bounds, order, scratch.emission, scratch.instances);
  b.sort_pairs(scratch.instances, count, job.grid.key_bits());
  finish_lists(b, job.grid, count, 0, scratch.instances, lists);
}

}  // namespace swiftgs
