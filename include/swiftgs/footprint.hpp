// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <tuple>

#include <swiftgs/bounds/bounds.hpp>
#include <swiftgs/span.hpp>
#include <swiftgs/tiles.hpp>
#include <swiftgs/views.hpp>

namespace swiftgs {

/// The tiles that a splat may touch, found once; emission expands them to intersections.
struct alignas(16) Footprint {
  /// Side of the mask in tiles.
  static constexpr int side = 8;

  std::uint64_t mask = 0;   ///< bit 8 r + c: the tile r rows below and c columns right of the first; zero
                            ///< where the splat spans more than 8 tiles a side, or touches none
  std::uint32_t count = 0;  ///< of tiles
  std::uint32_t first = 0;  ///< number of the first tile
};
static_assert(sizeof(Footprint) == 16);

/// The tiles of each splat of a frame. Holds for the bounds that found them and for these views alone.
struct FootprintsView {
  Span<const Footprint> each{};  ///< @shape{splats}
  Count intersections;           ///< sum of their counts
  Views views;
  const std::uint64_t* overflowed = nullptr;  ///< not 0: the frame has no room for them; null: it has
};

/// Storage of one frame's footprints on backend `B`.
template <class B>
struct Footprints {
  typename B::template Buffer<Footprint> each;
  std::size_t count = 0;  ///< splats
  std::uint64_t intersections = 0;
  Views views;

  FootprintsView view() const { return {{each.data(), count}, std::size_t(intersections), views}; }
  void reserve(B&, const Reservation& reserved) { each.reset_exactly(reserved.capacity.splats); }
  static auto buffers(auto& self) { return std::tie(self.each); }
};

namespace detail {
SWIFTGS_HD inline unsigned lowest_bit(std::uint64_t mask) {
#if defined(__CUDA_ARCH__)
  return unsigned(__ffsll(static_cast<long long>(mask))) - 1;
#else
  return unsigned(std::countr_zero(mask));
#endif
}

/// Calls f(tile) for the tiles of a footprint's mask, in rows of `stride` tiles.
template <class F>
SWIFTGS_HD void for_each_masked_tile(const Footprint& footprint, std::uint32_t stride, const F& f) {
  for (std::uint64_t mask = footprint.mask; mask != 0; mask &= mask - 1) {
    const unsigned bit = lowest_bit(mask);
    f(footprint.first + bit / Footprint::side * stride + bit % Footprint::side);
  }
}

/// The run of `tiles` in one row of their rectangle, and nothing outside of it.
template <class Tiles>
SWIFTGS_HD TileRun row_within(const Tiles& tiles, int row) {
  const TileRun run = tiles.row(row), columns = tiles.rect.columns;
  return {run.begin > columns.begin ? run.begin : columns.begin,
          run.end < columns.end ? run.end : columns.end};
}
}  // namespace detail

/// Footprint of `shape` within `bounds`, on the grid of its view.
template <BoundsPolicy Bounds>
SWIFTGS_HD Footprint find_footprint(const Bounds& bounds, const SplatShape& shape, TileGrid grid) {
  const auto tiles = bounds.tiles(shape, grid);
  const TileRect& rect = tiles.rect;
  if (rect.columns.size() == 0 || rect.rows.size() == 0) return {};
  Footprint footprint;
  footprint.first = grid.number(rect.columns.begin, rect.rows.begin);
  const bool fits = rect.columns.size() <= Footprint::side && rect.rows.size() <= Footprint::side;
  for (int row = rect.rows.begin; row < rect.rows.end; ++row) {
    const TileRun run = detail::row_within(tiles, row);
    footprint.count += std::uint32_t(run.size());
    if (fits && run.size() > 0)
      footprint.mask |= ((std::uint64_t(1) << run.size()) - 1)
                        << (Footprint::side * (row - rect.rows.begin) + run.begin - rect.columns.begin);
  }
  return footprint;
}

/// Calls f(tile) for the tiles of a splat with this footprint, `footprint.count` times, each tile once.
///
/// Splats too large for a mask are traversed by their bounds again. Code that counts and code that traverses
/// may round differently, where a compiler is free to. If this traversal finds more tiles than were counted,
/// the last are left out; if it finds fewer, other tiles of the grid take their place, in which rasterizers
/// find that the splat shows nothing.
template <BoundsPolicy Bounds, class F>
SWIFTGS_HD void for_each_tile(const Footprint& footprint, const Bounds& bounds, const SplatShape& shape,
                              TileGrid grid, const F& f) {
  detail::for_each_masked_tile(footprint, grid.stride, f);
  if (footprint.mask != 0 || footprint.count == 0) return;

  std::uint32_t left = footprint.count;
  const auto tiles = bounds.tiles(shape, grid);
  const TileRect& rect = tiles.rect;
  for (const bool inside : {true, false}) {
    const TileRun rows = inside ? rect.rows : grid.rows;
    for (int row = rows.begin; row < rows.end && left != 0; ++row) {
      TileRun run;
      if (row >= rect.rows.begin && row < rect.rows.end) run = detail::row_within(tiles, row);
      const TileRun traversed = inside ? run : grid.columns;
      for (int column = traversed.begin; column < traversed.end && left != 0; ++column)
        if (inside || column < run.begin || column >= run.end) f(grid.number(column, row)), --left;
    }
  }
}

}  // namespace swiftgs
