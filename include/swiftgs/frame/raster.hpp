// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/backend.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/passes.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/frame/splats.hpp>
#include <swiftgs/frame/tiles.hpp>
#include <swiftgs/frame/views.hpp>

namespace swiftgs {

/// Where a raster block of a view begins.
struct RasterBlockOrigin {
  std::uint32_t view;  ///< index
  int x, y;            ///< its first pixel in the view's frame
};

/// The raster blocks of all views. They are numbered as tiles are, but are smaller where tiles are larger.
struct RasterBlocks {
  std::uint32_t columns, rows;
  std::uint32_t of_tile;  ///< a side

  SWIFTGS_HD explicit RasterBlocks(const FrameTiles& tiles)
      : columns(tiles.columns * std::uint32_t(tiles.side / raster_block_side)),
        rows(tiles.rows * std::uint32_t(tiles.side / raster_block_side)),
        of_tile(std::uint32_t(tiles.side / raster_block_side)) {}
  SWIFTGS_HD std::size_t size() const { return std::size_t(columns) * rows; }

  /// Where the raster block in this column and row lies. It may lie outside of the view's frame.
  SWIFTGS_HD RasterBlockOrigin origin(const View* views, std::uint32_t count, std::uint32_t column,
                                      std::uint32_t row) const {
    const std::uint32_t tiles = columns / of_tile;
    const std::uint32_t view = count == 1 ? 0 : view_of_tile(views, count, row / of_tile * tiles);
    const std::uint32_t first_row = count == 1 ? 0 : views[view].grid.first / tiles * of_tile;
    return {view, int(column) * raster_block_side, int(row - first_row) * raster_block_side};
  }
};

/// What rasterizing one raster block takes.
struct RasterCounts {
  std::uint64_t intersections_visited = 0;  ///< of its tile's list, before all its pixels had stopped
  std::uint64_t rows_visited = 0;           ///< rows of pixels on which an intersection was evaluated
  std::uint64_t contributing_pairs = 0;     ///< (pixel, splat) pairs that were blended
  std::uint64_t pixels_stopped = 0;         ///< pixels that ended before their list

  SWIFTGS_HD RasterCounts& operator+=(const RasterCounts& o) {
    intersections_visited += o.intersections_visited, rows_visited += o.rows_visited;
    contributing_pairs += o.contributing_pairs, pixels_stopped += o.pixels_stopped;
    return *this;
  }
};

/// What a rasterizer turns into pixels. The views are read before it returns; everything else that is pointed
/// to, and the planes of their frames, lives where the backend can reach it.
struct RasterJob {
  SplatsView splats;
  ColoursView colours;
  TileListsView lists;
  Views views;
  RasterCounts* counts = nullptr;  ///< @shape{raster blocks} filled by hosts where not null
  AttributesView attributes{};
  bool only_attributes = false;  ///< all other planes were drawn

  /// Whether pixels of `view` have to remember splats.
  SWIFTGS_HD bool picks(const View& view) const { return !only_attributes && view.frame.picks(); }
  /// Whether pixels of `view` have to sum depths.
  SWIFTGS_HD bool sums_depth(const View& view) const { return !only_attributes && view.frame.depth.data; }
};

/// The raster blocks of `job`. Throws `InvalidArgument` if the lists are not of as many tiles as the
/// views have.
inline RasterBlocks raster_blocks_of(const RasterJob& job) {
  const FrameTiles& tiles = job.views.tiles;
  if (job.lists.ranges.size != tiles.size())
    detail::refuse("rasterize: the number of lists is ", job.lists.ranges.size,
                   ", expected a list for each of the frame's ", tiles.size(), " tiles");
  return RasterBlocks(tiles);
}

/// Arithmetic of a rasterizer for one splat in one raster block: constructed once from a shape that outlives
/// it, told each row, asked for each pixel. `alpha` is 0 where the pixel skips the splat.
template <class K>
concept AlphaKernel = requires(K kernel, const SplatShape& shape, vec2 first_centre, BlendRules rules,
                               float y, int column) {
  K(shape, first_centre, rules);
  kernel.start_row(y);
  { kernel.alpha(column) } -> std::same_as<float>;
};

/// Policy `R` rasterizes on any backend through its `Kernel`, and on backend `B` through an overload of
/// `rasterize(B&, R, const RasterJob&)` where that backend has one.
template <class R>
concept RasterPolicy = AlphaKernel<typename R::Kernel> && requires {
  { R::name } -> std::convertible_to<std::string_view>;
};

/// Whether `R` on backend `B` draws some frames sooner by coarser tiles (`coarse_tiles_gain`). Lists of
/// coarser tiles hold more splats that a raster block does not touch, so a rasterizer must refuse those at
/// little cost. Backends specialise it.
template <class B, class R>
inline constexpr bool may_gain_by_coarse_tiles = false;

/// Whether `shape` keeps any pixel of the row of a raster block whose centres run from `first_x` to first_x +
/// `raster_block_side` - 1 at height y.
///
/// Host rasterizers visit exactly the rows that this accepts, so images do not depend on the bounds that
/// listed the splat. Rounding is monotone along a row: no pixel of a refused row passes s <= cutoff. Device
/// kernels have a rule of their own.
SWIFTGS_HD inline bool row_touched(const SplatShape& shape, float first_x, float y) {
  const float dy = shape.below_mean(y), q = shape.l1 * dy, v = shape.l2 * dy;
  const float left = shape.l0 * shape.right_of_mean(first_x) + q;
  const float right = shape.l0 * shape.right_of_mean(first_x + float(raster_block_side - 1)) + q;
  const float nearest = left > 0 ? left : right < 0 ? right : 0.0f;
  return nearest * nearest + v * v <= shape.cutoff;
}

/// Whether cutoff + `log2_min`, where `log2_min` is log2(alpha_min / unit), is log2(opacity / unit) of a
/// splat in float. With a tiny alpha_min both terms are large, and digits are lost.
SWIFTGS_HD inline bool keeps_digits(float log2_min) { return log2_min >= -16; }

/// log2(opacity / unit) of a splat, without a logarithm where none is needed.
SWIFTGS_HD inline float log2_opacity(const SplatShape& shape, float log2_min, float unit) {
  if (keeps_digits(log2_min)) return shape.cutoff + log2_min;
#if defined(__CUDA_ARCH__)
  return __log2f(shape.opacity) - __log2f(unit);  // within 2^-22 of the larger magnitude or of 1
#else
  return std::log2(shape.opacity) - std::log2(unit);
#endif
}

/// Transmittance behind a splat of `alpha`, T (1 - alpha). Backends that have fused multiply-adds compute
/// fma(-alpha, T, T); this errs by no more than one rounding beyond it.
/// - Up to 1/2, 1 - alpha would round the same way for every splat of an opacity, and a thousand layers add
///   it up. T - alpha T rounds to either side.
/// - Above, 1 - alpha is exact, and T - alpha T would keep the rounding of a product that is up to a hundred
///   times what is left.
SWIFTGS_HD inline float dimmed(float transmittance, float alpha) {
  return alpha > 0.5f ? transmittance * (1 - alpha) : transmittance - alpha * transmittance;
}

}  // namespace swiftgs
