// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <string_view>

#include <swiftgs/backend.hpp>
#include <swiftgs/colours.hpp>
#include <swiftgs/message.hpp>
#include <swiftgs/plane/attributes.hpp>
#include <swiftgs/plane/picks.hpp>
#include <swiftgs/raster/raster_blocks.hpp>
#include <swiftgs/splats.hpp>
#include <swiftgs/store_pixel.hpp>
#include <swiftgs/tiles.hpp>

namespace swiftgs {

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

/// Writes the planes that `job` draws at column x of row y, but those of picked splats. `sums` are those of
/// its attributes.
SWIFTGS_HD inline void store_pixel(const RasterJob& job, const View& view, std::size_t x, std::size_t y,
                                   const BlendedPixel& pixel, const float* sums) {
  if (!job.only_attributes) store_pixel(view.frame, x, y, pixel, view.background);
  if (job.attributes.rows != 0) store_attributes(view, job.attributes, x, y, pixel.transmittance, sums);
}

/// Writes the planes of picked splats at column x of row y.
SWIFTGS_HD inline void store_picks(const RasterJob& job, const View& view, std::size_t x, std::size_t y,
                                   const SplatPicks& picks) {
  store_picks(view.frame, job.splats, job.colours.each, x, y, picks);
  if (!view.camera.depth_along_ray) return;
  const auto depth = [&](std::uint32_t splat) {
    return splat == SplatPicks::none ? 0.0f : job.attributes.ray_depth(splat).at(place_of(view, x, y));
  };
  if (view.frame.first_depth.data) view.frame.first_depth.row(y)[x] = depth(picks.first);
  if (view.frame.median_depth.data) view.frame.median_depth.row(y)[x] = depth(picks.median);
}

/// The raster blocks of `job`. Throws `std::invalid_argument` if the lists are not of as many tiles as the
/// views have.
inline RasterBlocks raster_blocks_of(const RasterJob& job) {
  const FrameTiles& tiles = job.views.tiles;
  if (job.lists.ranges.size != tiles.size())
    detail::refuse("rasterize: the number of lists is ", job.lists.ranges.size,
                   ", expected a list for each of the frame's ", tiles.size(), " tiles");
  return RasterBlocks(tiles);
}

/// A raster block within its view.
struct PlacedRasterBlock {
  const View& view;
  int x0, y0;         ///< its first pixel in the frame
  int columns, rows;  ///< of pixels within the frame; 0 or less where the raster block lies outside of it
  vec2 first_centre;  ///< of its first pixel in the image

  PlacedRasterBlock(const Views& views, const RasterBlocks& blocks, std::size_t block)
      : PlacedRasterBlock(views, blocks.place(views.each.data, std::uint32_t(views.size()),
                                              std::uint32_t(block) % blocks.columns,
                                              std::uint32_t(block) / blocks.columns)) {}

  bool empty() const { return columns <= 0 || rows <= 0; }
  TileRange list(const RasterJob& job) const {
    return job.lists.ranges[view.grid.tile_at(view.left() + x0, view.top() + y0)];
  }

 private:
  PlacedRasterBlock(const Views& views, const RasterBlockPlace& place)
      : view(views.each[place.view]),
        x0(place.x),
        y0(place.y),
        columns(std::min(raster_block_side, view.frame.width - place.x)),
        rows(std::min(raster_block_side, view.frame.height - place.y)),
        first_centre(float(view.left() + place.x) + 0.5f, float(view.top() + place.y) + 0.5f) {}
};

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
  const float q = shape.l1 * (y - shape.mean.y), v = shape.l2 * (y - shape.mean.y);
  const float left = shape.l0 * (first_x - shape.mean.x) + q;
  const float right = shape.l0 * (first_x + float(raster_block_side - 1) - shape.mean.x) + q;
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

/// Blends one raster block, pixel by pixel, on a host: the definition of what every rasterizer computes.
template <RasterPolicy R>
struct BlendRasterBlock {
  RasterJob job;
  RasterBlocks blocks;

  void operator()(std::size_t block) const {
    const PlacedRasterBlock place(job.views, blocks, block);
    if (job.counts) job.counts[block] = {};
    if (place.empty()) return;
    const View& view = place.view;
    const int x0 = place.x0, y0 = place.y0, columns = place.columns, rows = place.rows;
    const vec2 first_centre = place.first_centre;

    BlendedPixel pixels[raster_block_side][raster_block_side];
    SplatPicks picks[raster_block_side][raster_block_side];
    float sums[raster_block_side][raster_block_side][AttributesView::most];
    if (job.attributes.rows != 0) std::memset(sums, 0, sizeof sums);
    const bool pick = job.picks(view);
    const bool along_ray = hides_along_ray(view);
    bool stopped[raster_block_side][raster_block_side] = {};
    int live_in_row[raster_block_side];
    for (int row = 0; row < rows; ++row) live_in_row[row] = columns;
    int live = rows * columns;
    RasterCounts counts;

    // Blend its tile's splats front to back, until no pixel is left that could show another.
    const TileRange range = place.list(job);
    for (std::uint32_t at = range.begin; at < range.end && live > 0; ++at) {
      const std::uint32_t id = job.lists.ids[at];
      const SplatShape& shape = job.splats.shapes[id];
      const SplatColour& colour = job.colours.each[id];
      if (is_hidden(colour)) continue;
      typename R::Kernel kernel(shape, first_centre, view.rules);
      ++counts.intersections_visited;
      for (int row = 0; row < rows; ++row) {
        const float y = first_centre.y + float(row);
        if (live_in_row[row] == 0 || !row_touched(shape, first_centre.x, y)) continue;
        ++counts.rows_visited;
        kernel.start_row(y);
        for (int column = 0; column < columns; ++column) {
          BlendedPixel& pixel = pixels[row][column];
          if (stopped[row][column]) continue;
          const float alpha = kernel.alpha(column);
          if (alpha == 0) continue;
          const auto at_x = std::size_t(x0 + column), at_y = std::size_t(y0 + row);
          if (along_ray &&
              occluded(view, at_x, at_y, job.attributes.ray_depth(id).at(place_of(view, at_x, at_y))))
            continue;
          const float next = dimmed(pixel.transmittance, alpha);
          if (next < view.rules.stop_below || (!along_ray && occluded(view, at_x, at_y, colour.depth))) {
            stopped[row][column] = true;
            --live_in_row[row], --live, ++counts.pixels_stopped;
            continue;
          }
          const float weight = alpha * pixel.transmittance;
          pixel.colour += weight * colour.rgb;
          if (job.sums_depth(view)) pixel.depth += weight * colour.depth;
          pixel.transmittance = next;
          job.attributes.add(sums[row][column], id, weight);
          if (pick) picks[row][column].offer(id, weight, next, view.rules.first_below);
          ++counts.contributing_pairs;
        }
      }
    }

    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < columns; ++column) {
        const auto x = std::size_t(x0 + column), y = std::size_t(y0 + row);
        store_pixel(job, view, x, y, pixels[row][column], sums[row][column]);
        if (pick) store_picks(job, view, x, y, picks[row][column]);
      }
    if (job.counts) job.counts[block] = counts;
  }

 private:
  static bool occluded(const View& view, std::size_t x, std::size_t y, float depth) {
    return view.frame.occluder.data && depth >= view.frame.occluder_at(x, y);
  }
};

/// Renders every raster block of `job` with the arithmetic of `R::Kernel`, on hosts. Backends overload this
/// for policies that they have kernels for; a device also for all others, since one thread per raster block
/// would be slow. Throws as `raster_blocks_of`.
template <BackendPolicy B, RasterPolicy R>
requires(bool(B::reaches_host_memory)) void rasterize(B& b, R, const RasterJob& job) {
  const RasterBlocks blocks = raster_blocks_of(job);
  b.for_each(blocks.size(), BlendRasterBlock<R>{job, blocks});
}

}  // namespace swiftgs
