// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include <swiftgs/cuda/raster_block.cuh>
#include <swiftgs/cuda/stages.hpp>
#include <swiftgs/cuda/warp.cuh>
#include <swiftgs/frame/raster.hpp>
#include <swiftgs/plane/attributes.hpp>
#include <swiftgs/plane/picks.hpp>
#include <swiftgs/tools/policy_lists.hpp>

namespace swiftgs::kernels {

inline constexpr unsigned raster_pixels_threads = raster_block_side * raster_block_side;

/// `BlendRasterBlock` on a device, with its decisions: one thread block per raster block, one
/// thread per pixel. A warp traverses the list by itself until its pixels have stopped. Without `planes`
/// there are neither picks nor attributes.
template <RasterPolicy R, bool planes, class ViewSource>
__global__ void __launch_bounds__(raster_pixels_threads)
    raster_pixels(const __grid_constant__ RasterInput<ViewSource> input) {
  const RasterJob& job = input.job;
  const OwnRasterBlock raster_block(input);
  if (raster_block.outside(input)) return;
  const View& view = input.views[raster_block.view];
  const FrameView& frame = view.frame;
  const int x0 = raster_block.x, y0 = raster_block.y;
  const int column = int(threadIdx.x) % raster_block_side, row = int(threadIdx.x) / raster_block_side;
  const int x = x0 + column, y = y0 + row;
  const bool inside = x < frame.width && y < frame.height;
  const float occluder =
      inside && frame.occluder.data ? frame.occluder_at(std::size_t(x), std::size_t(y)) : INFINITY;

  BlendedPixel pixel;
  SplatPicks picks;
  float sums[AttributesView::most]{};
  const bool along_ray = planes && hides_along_ray(view);
  bool live = inside;

  const vec2 first_centre(float(view.left() + x0) + 0.5f, float(view.top() + y0) + 0.5f);
  const float centre_y = first_centre.y + float(row);
  const TileRange range = raster_block.list(input);
  if (!range.drawn()) return;
  for (std::uint32_t at = range.begin; at < range.end && __any_sync(whole_warp, live); ++at) {
    const std::uint32_t id = job.lists.ids[at];
    const SplatColour colour = job.colours.each[id];
    if (is_colourless(colour)) continue;
    const SplatShape shape = job.splats.shapes[id];
    if (!live || !row_touched(shape, first_centre.x, centre_y)) continue;
    typename R::Kernel kernel(shape, first_centre, view.rules);
    kernel.start_row(centre_y);
    const float alpha = kernel.alpha(column);
    if (alpha == 0) continue;
    if (along_ray) {
      const vec2 at_pixel = point_of(view, std::size_t(x), std::size_t(y));
      if (job.attributes.ray_depth(id).at(at_pixel) >= occluder) continue;
    }
    const float next = dimmed(pixel.transmittance, alpha);
    if (next < view.rules.stop_below || (!along_ray && colour.depth >= occluder)) {
      live = false;
      continue;
    }
    const float weight = alpha * pixel.transmittance;
    pixel.colour += weight * colour.rgb;
    pixel.depth += weight * colour.depth;
    pixel.transmittance = next;
    if constexpr (planes) {
      job.attributes.add(sums, id, weight);
      picks.offer(id, weight, next, view.rules.first_below);
    }
  }

  if (inside) {
    store_pixel(job, view, std::size_t(x), std::size_t(y), pixel, sums);
    if constexpr (planes)
      if (job.picks(view)) store_picks(job, view, std::size_t(x), std::size_t(y), picks);
  }
}

template <RasterPolicy R>
struct RasterPixelsKernel {
  static constexpr unsigned threads = raster_pixels_threads;
  template <bool planes, class ViewSource>
  static constexpr auto of = &raster_pixels<R, planes, ViewSource>;
};

template <RasterPolicy R>
void run_raster_pixels(Cuda& cuda, const RasterJob& job) {
  static constexpr ComposedName name{"rasterize ", R::name};
  launch_raster_blocks<RasterPixelsKernel<R>>(cuda, name.view().data(), job, sums_or_picks(job));
}

}  // namespace swiftgs::kernels
