// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <concepts>
#include <cstdint>
#include <string_view>

#include <swiftgs/backend.hpp>
#include <swiftgs/colours.hpp>
#include <swiftgs/conventions.hpp>
#include <swiftgs/frame.hpp>
#include <swiftgs/splats.hpp>
#include <swiftgs/store_pixel.hpp>
#include <swiftgs/tiles.hpp>

namespace swiftgs {

/// The thresholds of blending, from `Conventions`.
struct BlendRules {
  float alpha_min = 0;   ///< less alpha is skipped
  float alpha_max = 0;   ///< more is cut
  float stop_below = 0;  ///< a pixel ends before the splat that would bring its transmittance below this

  static BlendRules from(const Conventions& c) {
    return {c.alpha_min, c.alpha_max, c.stop_at_equal ? std::nextafter(c.stop, 1.0f) : c.stop};
  }
};

/// What rasterizing one tile took.
struct TileCounts {
  std::uint64_t instances_visited = 0;   ///< of the tile's list, before all its pixels had stopped
  std::uint64_t rows_visited = 0;        ///< rows of pixels on which an instance was evaluated
  std::uint64_t contributing_pairs = 0;  ///< (pixel, splat) pairs that were blended
  std::uint64_t pixels_stopped = 0;      ///< pixels that ended before their list

  SWIFTGS_HD TileCounts& operator+=(const TileCounts& o) {
    instances_visited += o.instances_visited, rows_visited += o.rows_visited;
    contributing_pairs += o.contributing_pairs, pixels_stopped += o.pixels_stopped;
    return *this;
  }
};

/// What a rasterizer turns into pixels. Everything that is pointed to lives where the backend can reach it.
struct RasterJob {
  SplatsView splats;
  ColoursView colours;
  TileListsView lists;
  TileGrid grid;
  BlendRules rules;
  vec3 background{0};
  FrameView frame;
  TileCounts* counts = nullptr;  ///< @shape{tiles} filled where not null
};

/// Arithmetic of a rasterizer for one splat in one tile: constructed once from a shape that outlives it, told
/// each row, asked for each pixel. `alpha` is 0 where the pixel skips the splat.
template <class K>
concept AlphaKernel = requires(K kernel, const SplatShape& shape, vec2 first_centre, BlendRules rules,
                               float y, int column) {
  K(shape, first_centre, rules);
  kernel.start_row(y);
  { kernel.alpha(column) } -> std::same_as<float>;
};

/// Policy `R` rasterizes on any host backend through its `Kernel`, and on backend `B` through an overload of
/// `rasterize(B&, R, const RasterJob&)` where that backend has one.
template <class R>
concept RasterPolicy = AlphaKernel<typename R::Kernel> && requires {
  { R::name } -> std::convertible_to<std::string_view>;
};

/// Whether `shape` keeps any pixel of the row of a tile whose centres run from `first_x` to first_x + 15 at
/// height y.
///
/// Host rasterizers visit exactly the rows that this accepts, so that what is drawn does not depend on how
/// wide the bounds were that listed the splat. Rounding is monotone along a row, hence no pixel of a refused
/// row passes the test s <= reach in the same arithmetic. Kernels of devices that do not go by rows have a
/// rule of their own.
SWIFTGS_HD inline bool row_touched(const SplatShape& shape, float first_x, float y) {
  const float q = shape.l1 * (y - shape.mean.y), v = shape.l2 * (y - shape.mean.y);
  const float left = shape.l0 * (first_x - shape.mean.x) + q;
  const float right = shape.l0 * (first_x + float(tile_side - 1) - shape.mean.x) + q;
  const float nearest = left > 0 ? left : right < 0 ? right : 0.0f;
  return nearest * nearest + v * v <= shape.reach;
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

/// Blends one tile, pixel by pixel, on a host: the plain form of what every rasterizer computes.
template <RasterPolicy R>
struct RasterizeTile {
  RasterJob job;

  void operator()(std::size_t tile) const {
    const int x0 = int(tile % job.grid.columns) * tile_side, y0 = int(tile / job.grid.columns) * tile_side;
    const int columns = job.frame.width - x0 < tile_side ? job.frame.width - x0 : tile_side;
    const int rows = job.frame.height - y0 < tile_side ? job.frame.height - y0 : tile_side;

    BlendedPixel pixels[tile_side][tile_side];
    bool stopped[tile_side][tile_side] = {};
    int live_in_row[tile_side];
    for (int row = 0; row < rows; ++row) live_in_row[row] = columns;
    int live = rows * columns;
    TileCounts counts;

    // Blend the tile's splats front to back, until no pixel is left that could show another.
    const vec2 first_centre(float(x0) + 0.5f, float(y0) + 0.5f);
    const TileRange range = job.lists.ranges[tile];
    for (std::uint32_t at = range.begin; at < range.end && live > 0; ++at) {
      const std::uint32_t id = job.lists.ids[at];
      const SplatShape& shape = job.splats.shapes[id];
      const SplatColour& colour = job.colours.each[id];
      if (is_hidden(colour)) continue;
      typename R::Kernel kernel(shape, first_centre, job.rules);
      ++counts.instances_visited;
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
          const float next = dimmed(pixel.transmittance, alpha);
          if (next < job.rules.stop_below || occluded(x0 + column, y0 + row, colour.depth)) {
            stopped[row][column] = true;
            --live_in_row[row], --live, ++counts.pixels_stopped;
            continue;
          }
          const float weight = alpha * pixel.transmittance;
          pixel.colour += weight * colour.rgb;
          if (job.frame.depth.data) pixel.depth += weight * colour.depth;
          pixel.transmittance = next;
          ++counts.contributing_pairs;
        }
      }
    }

    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < columns; ++column)
        store_pixel(job.frame, std::size_t(x0 + column), std::size_t(y0 + row), pixels[row][column],
                    job.background);
    if (job.counts) job.counts[tile] = counts;
  }

 private:
  /// Lists run front to back, so a pixel ends at the first splat that the caller's surface hides.
  bool occluded(int x, int y, float depth) const {
    const Plane<const float>& occluder = job.frame.occluder;
    return occluder.data && depth >= occluder.row(std::size_t(y))[x];
  }
};

/// Renders every tile of `job` with the arithmetic of `R::Kernel`, on hosts. Backends overload this for
/// policies that they have kernels for; a device, where a thread a tile would be of no use, runs no others.
template <BackendPolicy B, RasterPolicy R>
requires(bool(B::reaches_host_memory)) void rasterize(B& b, R, const RasterJob& job) {
  b.for_each(job.grid.size(), RasterizeTile<R>{job});
}

}  // namespace swiftgs
