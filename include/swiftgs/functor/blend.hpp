// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The scalar form of rasterization: blends all that a frame may ask for.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include <swiftgs/frame/backend.hpp>
#include <swiftgs/frame/raster.hpp>
#include <swiftgs/plane/attributes.hpp>
#include <swiftgs/plane/picks.hpp>
#include <swiftgs/raster/store.hpp>

namespace swiftgs {

/// A raster block within its view.
struct RasterBlockOfView {
  const View& view;
  int x0, y0;         ///< its first pixel in the frame
  int columns, rows;  ///< of pixels within the frame; 0 or less where the raster block lies outside of it
  vec2 first_centre;  ///< of its first pixel in the image

  RasterBlockOfView(const Views& views, const RasterBlocks& blocks, std::size_t block)
      : RasterBlockOfView(views, blocks.origin(views.each.data, std::uint32_t(views.size()),
                                               std::uint32_t(block) % blocks.columns,
                                               std::uint32_t(block) / blocks.columns)) {}

  bool empty() const { return columns <= 0 || rows <= 0; }
  TileRange list(const RasterJob& job) const {
    return job.lists.ranges[view.grid.tile_at(view.left() + x0, view.top() + y0)];
  }

 private:
  RasterBlockOfView(const Views& views, const RasterBlockOrigin& origin)
      : view(views.each[origin.view]),
        x0(origin.x),
        y0(origin.y),
        columns(std::min(raster_block_side, view.frame.width - origin.x)),
        rows(std::min(raster_block_side, view.frame.height - origin.y)),
        first_centre(float(view.left() + origin.x) + 0.5f, float(view.top() + origin.y) + 0.5f) {}
};

/// Blends one raster block, pixel by pixel, on a host: the definition of what every rasterizer computes.
template <RasterPolicy R>
struct BlendRasterBlock {
  RasterJob job;
  RasterBlocks blocks;

  void operator()(std::size_t block) const {
    const RasterBlockOfView here(job.views, blocks, block);
    if (job.counts) job.counts[block] = {};
    if (here.empty()) return;
    const View& view = here.view;
    const int x0 = here.x0, y0 = here.y0, columns = here.columns, rows = here.rows;
    const vec2 first_centre = here.first_centre;

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
    const TileRange range = here.list(job);
    for (std::uint32_t at = range.begin; at < range.end && live > 0; ++at) {
      const std::uint32_t id = job.lists.ids[at];
      const SplatShape& shape = job.splats.shapes[id];
      const SplatColour& colour = job.colours.each[id];
      if (is_colourless(colour)) continue;
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
              occluded(view, at_x, at_y, job.attributes.ray_depth(id).at(point_of(view, at_x, at_y))))
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
template <FunctorBackend B, RasterPolicy R>
requires(bool(B::reaches_host_memory)) void rasterize(B& b, R, const RasterJob& job) {
  const RasterBlocks blocks = raster_blocks_of(job);
  b.for_each(blocks.size(), BlendRasterBlock<R>{job, blocks});
}

}  // namespace swiftgs
