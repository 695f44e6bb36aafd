// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Which splats go to which rank, in loops that every backend can run.

#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <tuple>

#include <swiftgs/api.hpp>
#include <swiftgs/backend.hpp>
#include <swiftgs/bounds/bounds.hpp>
#include <swiftgs/colours.hpp>
#include <swiftgs/footprint.hpp>
#include <swiftgs/shade_stage.hpp>
#include <swiftgs/splats.hpp>
#include <swiftgs/tiles.hpp>
#include <swiftgs/type_list.hpp>

namespace swiftgs {

/// Splats that one iteration of a loop looks at, in their order.
inline constexpr std::size_t packed_at_once = 256;

/// Which ranks draw tiles of a splat. Every splat of a tile list must reach the rank that draws the tile, so
/// the answer comes from the footprints that one process would emit instances from.
template <class Bounds>
struct BandsOfSplat {
  SplatsView splats;
  Span<const Footprint> footprints;
  const TileGrid* grids;  ///< of each view
  Bounds bounds;
  const std::uint16_t* rank_of_row;  ///< @shape{rows of the sheet}

  /// Ranks from `begin` on, before `end`.
  SWIFTGS_HD TileRun operator()(std::size_t i) const {
    const TileRun rows = sheet_rows(i);
    if (rows.size() == 0) return {};
    return {int(rank_of_row[rows.begin]), int(rank_of_row[rows.end - 1]) + 1};
  }

 private:
  SWIFTGS_HD TileRun sheet_rows(std::size_t i) const {
    const Footprint& footprint = footprints[i];
    if (footprint.count == 0) return {};
    const TileGrid& grid = grids[splats.view(i)];
    if (footprint.mask != 0) {
      const int first = int(footprint.first / grid.stride);
      return {first, first + int(highest_bit(footprint.mask)) / Footprint::side + 1};
    }
    // Its bounds are walked again, and may round otherwise than when its tiles were counted.
    const TileRun rows = bounds.tiles(splats.shapes[i], grid).rect.rows;
    const int top = int(grid.first / grid.stride) - grid.rows.begin;
    const int first = rows.begin > grid.rows.begin ? rows.begin - 1 : grid.rows.begin;
    const int last = rows.end < grid.rows.end ? rows.end + 1 : grid.rows.end;
    return {first + top, last + top};
  }
  SWIFTGS_HD static unsigned highest_bit(std::uint64_t mask) {
#if defined(__CUDA_ARCH__)
    return 63u - unsigned(__clzll(static_cast<long long>(mask)));
#else
    return 63u - unsigned(std::countl_zero(mask));
#endif
  }
};

/// Counts for each rank the splats of one part that go to it.
template <class Bounds>
struct SWIFTGS_API CountForBands {
  BandsOfSplat<Bounds> bands;
  std::size_t splats, parts;
  int ranks;
  std::uint32_t* counts;  ///< @shape{ranks, parts}

  SWIFTGS_HD void operator()(std::size_t part) const {
    for (int r = 0; r < ranks; ++r) counts[std::size_t(r) * parts + part] = 0;
    const std::size_t begin = part * packed_at_once;
    const std::size_t end = splats - begin < packed_at_once ? splats : begin + packed_at_once;
    for (std::size_t i = begin; i < end; ++i) {
      const TileRun to = bands(i);
      for (int r = to.begin; r < to.end; ++r) ++counts[std::size_t(r) * parts + part];
    }
  }
};

/// Lists them, from where the sums of the counts say, which it moves on.
template <class Bounds>
struct SWIFTGS_API ListForBands {
  BandsOfSplat<Bounds> bands;
  std::size_t splats, parts;
  std::uint32_t* places;  ///< @shape{ranks, parts}
  std::uint32_t* ids;     ///< of splats, those for one rank behind those for the rank before it

  SWIFTGS_HD void operator()(std::size_t part) const {
    const std::size_t begin = part * packed_at_once;
    const std::size_t end = splats - begin < packed_at_once ? splats : begin + packed_at_once;
    for (std::size_t i = begin; i < end; ++i) {
      const TileRun to = bands(i);
      for (int r = to.begin; r < to.end; ++r) ids[places[std::size_t(r) * parts + part]++] = std::uint32_t(i);
    }
  }
};

/// Copies every `step`-th word: where the splats for each rank begin.
struct SWIFTGS_API PickWords {
  const std::uint32_t* from;
  std::size_t step;
  std::uint32_t* to;
  SWIFTGS_HD void operator()(std::size_t i) const { to[i] = from[i * step]; }
};

/// Copies listed splats without their colours.
struct SWIFTGS_API PackShapes {
  SplatsView splats;
  const std::uint32_t* ids;
  std::uint32_t first_view;  ///< of the band that they go to
  SplatShape* shapes;
  float* depths;
  std::uint16_t* of_view;  ///< null if the band shows one view

  SWIFTGS_HD void operator()(std::size_t i) const {
    const std::uint32_t id = ids[i];
    shapes[i] = splats.shapes[id], depths[i] = splats.depths[id];
    if (of_view) of_view[i] = std::uint16_t(splats.view(id) - first_view);
  }
};

/// Copies the colours of listed splats.
struct SWIFTGS_API PackColours {
  const SplatColour* from;
  const std::uint32_t* ids;
  SplatColour* to;
  SWIFTGS_HD void operator()(std::size_t i) const { to[i] = from[ids[i]]; }
};

/// Notes where splat i is hidden.
struct SWIFTGS_API NoteHidden {
  const SplatColour* colours;
  std::uint32_t* hidden;

  SWIFTGS_HD void operator()(std::size_t i) const {
    if (!is_hidden(colours[i])) return;
#if defined(__CUDA_ARCH__)
    *hidden = 1;
#else
    std::atomic_ref<std::uint32_t>(*hidden).store(1, std::memory_order_relaxed);
#endif
  }
};

/// The loops beside those of bounds: a device's compiler must see them.
using PackLoops = TypeList<PickWords, PackShapes, PackColours, NoteHidden, ClearWord>;

/// What a rank sends, in the order of the ranks that it goes to, and within it in the order of the Gaussians.
template <class B>
struct PackedSplats {
  typename B::template Buffer<std::uint32_t> places, ids, begins;
  typename B::template Buffer<std::uint16_t> rank_of_row, of_view;
  typename B::template Buffer<TileGrid> grids;
  typename B::template Buffer<SplatShape> shapes;
  typename B::template Buffer<float> depths;
  typename B::template Buffer<SplatColour> colours;

  static auto buffers(auto& self) {
    return std::tie(self.places, self.ids, self.begins, self.rank_of_row, self.of_view, self.grids,
                    self.shapes, self.depths, self.colours);
  }
};

}  // namespace swiftgs
