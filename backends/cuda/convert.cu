// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>
#include <vector>

#include <swiftgs/cuda/launch.cuh>
#include <swiftgs/cuda/raster_block.cuh>
#include <swiftgs/cuda/stages.hpp>
#include <swiftgs/raster/store.hpp>

#include "planes.hpp"
#include "state.hpp"

namespace swiftgs::kernels {
namespace {

constexpr unsigned redirect_threads = 256, convert_threads = raster_block_side * raster_block_side;

/// Colours of all views as rasterizers blend them, RGBA, laid out as tiles are numbered.
struct BlendedColours {
  vec4* first;
  FrameTiles tiles;

  static std::size_t size(const FrameTiles& tiles) {
    return tiles.size() * std::size_t(tiles.side) * std::size_t(tiles.side);
  }
  SWIFTGS_HD std::size_t width() const { return std::size_t(tiles.columns) * std::size_t(tiles.side); }
  SWIFTGS_HD vec4* of(const View& view) const {
    return first + std::size_t(view.grid.first / tiles.columns) * std::size_t(tiles.side) * width();
  }
  /// Lets `view` be drawn to them, if its colours are to be converted.
  SWIFTGS_HD void take(View& view) const {
    FrameView& frame = view.frame;
    if (frame.conversion == Conversion::as_is || !frame.colour.data) return;
    frame.colour = {of(view), std::ptrdiff_t(width() * sizeof(vec4))};
    frame.format = PixelFormat::rgba_float, frame.over = false;
    view.background = vec3(0);
  }
};

BlendedColours colours_of(Cuda& cuda, const FrameTiles& tiles) {
  RasterMemory& raster = RasterMemory::of(cuda);
  return {raster.at_least(cuda, raster.colours, BlendedColours::size(tiles)), tiles};
}

/// Colour, alpha and depths of means, which were drawn.
struct DrawnPlanes {
  /// Takes them from `view`.
  SWIFTGS_HD void take(View& view) const {
    FrameView& frame = view.frame;
    frame.colour = {}, frame.alpha = {};
    if (!view.camera.depth_along_ray) frame.depth = {};
  }
};

/// One thread per view.
template <class Planes>
__global__ void __launch_bounds__(redirect_threads)
    redirect_views(const View* from, std::uint32_t count, const Planes planes, View* to) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i >= count) return;
  View view = from[i];
  planes.take(view);
  to[i] = view;
}

/// Replaces stored views by copies after planes.take(view), in memory of the backend.
template <class Planes>
void redirect_stored(Cuda& cuda, Views& views, const Planes& planes) {
  RasterMemory& raster = RasterMemory::of(cuda);
  View* const to = raster.at_least(cuda, raster.views, views.size());
  launch("redirect_views", redirect_views<Planes>, blocks_for(views.size(), redirect_threads),
         redirect_threads, cuda.stream(), views.stored, std::uint32_t(views.size()), planes, to);
  views.stored = to;
}

/// One thread block per raster block, one thread per pixel.
template <class ViewSource>
__global__ void __launch_bounds__(convert_threads)
    convert_colours(const __grid_constant__ RasterInput<ViewSource> input, const BlendedColours colours) {
  const OwnRasterBlock raster_block(input);
  if (raster_block.outside(input) || !raster_block.list(input).drawn()) return;
  const View& view = input.views[raster_block.view];
  const FrameView& frame = view.frame;
  const auto x = std::size_t(raster_block.x) + threadIdx.x % raster_block_side;
  const auto y = std::size_t(raster_block.y) + threadIdx.x / raster_block_side;
  if (x >= std::size_t(frame.width) || y >= std::size_t(frame.height)) return;
  if (frame.conversion == Conversion::as_is || !frame.colour.data) return;
  const vec4 blended = colours.of(view)[y * colours.width() + x];
  detail::store_colour(frame, x, y,
                       detail::lay_and_convert(frame, x, y, blended, 1 - blended.a, view.background));
}
}  // namespace

Views redirect_colours(Cuda& cuda, const Views& views, View& one) {
  const BlendedColours colours = colours_of(cuda, views.tiles);
  Views out = views;
  if (views.stored) {
    redirect_stored(cuda, out, colours);
  } else {
    one = views.each[0];
    colours.take(one);
    out.each = {&one, 1};
  }
  return out;
}

Views further_planes_of(Cuda& cuda, const Views& views, std::vector<View>& each) {
  each.assign(views.begin(), views.end());
  for (View& view : each) DrawnPlanes().take(view);
  Views out = views;
  out.each = {each.data(), each.size()};
  if (views.stored) redirect_stored(cuda, out, DrawnPlanes());
  return out;
}

void convert_colours(Cuda& cuda, const RasterJob& job) {
  const RasterBlocks raster_blocks = raster_blocks_of(job);
  const BlendedColours colours = colours_of(cuda, job.views.tiles);
  with_views(job.views, [&]<class ViewSource>(const ViewSource& views) {
    launch("convert_colours", convert_colours<ViewSource>, blocks_of(raster_blocks), convert_threads,
           cuda.stream(), RasterInput<ViewSource>{job, views, raster_blocks, nullptr}, colours);
  });
}

}  // namespace swiftgs::kernels
