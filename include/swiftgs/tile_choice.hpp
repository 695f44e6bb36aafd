// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include <swiftgs/frame_plan.hpp>
#include <swiftgs/span.hpp>
#include <swiftgs/tiles.hpp>
#include <swiftgs/views.hpp>

namespace swiftgs {

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
  /// them. They hold until the next call.
  Span<const View> choose(const FrameKey& key, Span<const View> views) {
    if (key != key_) return views;
    std::uint64_t pixels = 0;
    for (const View& view : views)
      pixels += std::uint64_t(view.frame.width) * std::uint64_t(view.frame.height);
    if (!coarse_tiles_gain(visible_, pixels)) return views;
    // All views have tiles of one side.
    coarse_.clear();
    for (const View& view : views) {
      coarse_.push_back(view);
      coarse_.back().grid = coarse(view);
      if (coarse_.back().grid.side == view.grid.side) return views;
    }
    return {coarse_.data(), coarse_.size()};
  }

  /// A frame with this key showed so many splats.
  void learn(const FrameKey& key, std::uint64_t visible) { key_ = key, visible_ = visible; }

 private:
  FrameKey key_;
  std::uint64_t visible_ = 0;
  std::vector<View> coarse_;
};

}  // namespace swiftgs
