// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a renderer learns from its frames for later ones: capacities, and tile sizes of a device.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/frame_plan.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/frame/tiles.hpp>
#include <swiftgs/frame/views.hpp>

namespace swiftgs {

/// Throws `CapacityError` where a frame has more intersections than a tile list can index.
inline void check_intersections(std::uint64_t total) {
  if (total > max_intersections) throw CapacityError("intersections in one frame", total, max_intersections);
}

/// `count` and an eighth more, so that the next frame need not grow.
inline std::size_t with_spare(std::uint64_t count) { return std::size_t(count + count / 8 + 1); }

/// The capacity of a device's frames. It grows with them.
class FrameCapacity {
 public:
  /// Calls draw(capacity) until the `FrameReport` that it returns has not overflowed. Returns the last
  /// report. Throws `CapacityError` beyond `max_intersections`. If it throws, the capacity stays as it was:
  /// otherwise the next frame would ask for the memory that this one did not get.
  template <class Draw>
  FrameReport draw_until_it_fits(const Draw& draw) {
    const Capacity before = capacity_;
    try {
      for (;;) {
        const FrameReport report = draw(capacity_);
        if (report.overflowed == 0) return report;
        grow(report);
      }
    } catch (...) {
      capacity_ = before;
      throw;
    }
  }

  /// Grows to `capacity` where that is more.
  void at_least(const Capacity& capacity) {
    capacity_.splats = std::max(capacity_.splats, capacity.splats);
    capacity_.intersections = std::max(capacity_.intersections, capacity.intersections);
  }

 private:
  /// Grows to the numbers of `report` plus an eighth.
  void grow(const FrameReport& report) {
    check_intersections(report.intersections);
    at_least({with_spare(report.visible),
              std::min(with_spare(report.intersections), std::size_t(max_intersections))});
  }

  Capacity capacity_{1, 1};
};

/// Side of coarser tiles @units{pixels}. A renderer takes them for large images with few splats, if bounds
/// are conservative and its rasterizer may gain: sorting fewer intersections gains more than rasterization
/// loses.
inline constexpr int coarse_tile_side = 2 * default_tile_side;

/// Whether tiles of `coarse_tile_side` are quicker. Measured on an H200 (docs/cuda.md): with fewer than
/// a splat for ten pixels they are, and in small images neither matters.
/// With less than 0.55 intersections a pixel frames take up to 8 % less time, with more than 0.65 they take
/// more. A frame knows its intersections only after its tiles are chosen, so the splats decide.
constexpr bool coarse_tiles_gain(std::uint64_t splats, std::uint64_t pixels) {
  return pixels >= 1'500'000 && 10 * splats < pixels;
}

/// The tiles of a view, of `default_tile_side`, with `coarse_tile_side` in its place. Unchanged if they have
/// another side or do not cover the frame, or unless they start on a border of coarser tiles.
inline TileGrid coarse(const View& view) {
  const TileGrid& grid = view.grid;
  constexpr int times = coarse_tile_side / default_tile_side;
  const TileGrid usual = TileGrid::covering(view.frame.width, view.frame.height);
  if (grid.side != usual.side || grid.columns.begin % times != 0 || grid.rows.begin % times != 0 ||
      grid.columns.size() != usual.columns.size() || grid.rows.size() != usual.rows.size())
    return grid;
  const TileGrid whole = TileGrid::covering(view.frame.width, view.frame.height, coarse_tile_side);
  const auto from = [](int begin, TileRun run) { return TileRun{begin / times, begin / times + run.size()}; };
  return {from(grid.columns.begin, whole.columns), from(grid.rows.begin, whole.rows), whole.side, 0,
          whole.stride};
}

/// Chooses the side of a frame's tiles by what the frame before it showed.
class TileChoice {
 public:
  /// The views of a frame, with coarser tiles if the frame before had the same `key` and would have gained by
  /// them; never unless they `may_gain`. They hold until the next call.
  Span<const View> choose(const FrameKey& key, Span<const View> views, bool may_gain) {
    if (key != key_) key_ = key, visible_.reset();
    if (!may_gain || !visible_) return views;
    std::uint64_t pixels = 0;
    for (const View& view : views)
      pixels += std::uint64_t(view.frame.width) * std::uint64_t(view.frame.height);
    if (!coarse_tiles_gain(*visible_, pixels)) return views;
    // All views have tiles of one side.
    coarse_.clear();
    for (const View& view : views) {
      coarse_.push_back(view);
      coarse_.back().grid = coarse(view);
      if (coarse_.back().grid.side == view.grid.side) return views;
    }
    return {coarse_.data(), coarse_.size()};
  }

  /// The frame that it chose for last showed so many splats.
  void learn(std::uint64_t visible) { visible_ = visible; }

 private:
  FrameKey key_;
  std::optional<std::uint64_t> visible_;  ///< of the last frame with this key
  std::vector<View> coarse_;
};

}  // namespace swiftgs
