// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <swiftgs/cuda/launch.cuh>
#include <swiftgs/cuda/stages.hpp>
#include <swiftgs/cuda/view_source.cuh>
#include <swiftgs/frame/raster.hpp>

namespace swiftgs::kernels {

/// What the thread blocks of a rasterizer share: one thread block per raster block.
template <class ViewSource>
struct RasterInput {
  RasterJob job;
  ViewSource views;
  RasterBlocks raster_blocks;
  const std::uint32_t* order;  ///< @shape{raster blocks} as `order_raster_blocks` has it; null: by rows
};

/// Column and row of a raster block in its frame.
struct RasterBlockIndex {
  std::uint32_t column, row;

  /// In a word of `order_raster_blocks`.
  __device__ static RasterBlockIndex of(std::uint32_t word) { return {word & 0xffff, word >> 16}; }
  __device__ std::uint32_t word() const { return row << 16 | column; }
};

/// The raster blocks of a frame, roughly longest lists first: started last, a long one would delay the frame.
/// Null, for an order by rows, if the device holds all thread blocks at once, or if there are so many that
/// the end is short.
SWIFTGS_API const std::uint32_t* order_raster_blocks(Cuda& cuda, const TileListsView& lists,
                                                     const RasterBlocks& raster_blocks);

/// Rows of a grid that is not cut into slices.
inline constexpr std::uint32_t rows_of_slice = 32768;

/// One thread block per raster block, in columns and rows as they lie in the images, so that no thread
/// divides. A grid has at most 65,535 rows, so further ones are slices of it.
inline dim3 blocks_of(const RasterBlocks& raster_blocks) {
  const std::uint32_t rows = std::min(raster_blocks.rows, rows_of_slice);
  return dim3(raster_blocks.columns, rows, (raster_blocks.rows + rows - 1) / rows);
}

/// The raster block of this thread block.
struct OwnRasterBlock {
  std::uint32_t view;  ///< index
  int x, y;            ///< its first pixel in the view's frame

  template <class ViewSource>
  __device__ explicit OwnRasterBlock(const RasterInput<ViewSource>& input)
      : OwnRasterBlock(input, index(input)) {}
  template <class ViewSource>
  __device__ OwnRasterBlock(const RasterInput<ViewSource>& input, RasterBlockIndex index) {
    const RasterBlockOrigin origin = input.views.origin(input.raster_blocks, index.column, index.row);
    view = origin.view, x = origin.x, y = origin.y;
  }

  /// Whether it has no pixel of its view: if the view is narrower than another, or if slices overlap the last
  /// row. Never in a frame of one view.
  template <class ViewSource>
  __device__ bool outside(const RasterInput<ViewSource>& input) const {
    if constexpr (ViewSource::only) {
      return false;
    } else {
      const FrameView& frame = input.views[view].frame;
      return x >= frame.width || y >= frame.height;
    }
  }

  template <class ViewSource>
  __device__ static RasterBlockIndex index(const RasterInput<ViewSource>& input) {
    const std::uint32_t row = blockIdx.z * gridDim.y + blockIdx.y;
    return input.order ? RasterBlockIndex::of(input.order[row * gridDim.x + blockIdx.x])
                       : RasterBlockIndex{blockIdx.x, row};
  }

  /// Range of the raster block's list. It depends only on the thread block's index, so the compiler sees one
  /// range for all threads and generates no code for diverged warps, which would cost 3 % on a long list.
  template <class ViewSource>
  __device__ TileRange list(const RasterInput<ViewSource>& input) const {
    const View& of = input.views[view];
    return input.job.lists.ranges[of.grid.tile_at(of.left() + x, of.top() + y)];
  }
};

/// A pixel of a frame, and the depth at which the frame's occluder hides splats.
struct FramePixel {
  int x, y;
  bool inside;
  float occluder;  ///< depth of what hides the splats behind it

  __device__ FramePixel(const FrameView& frame, int x_, int y_, bool extras)
      : x(x_), y(y_), inside(x_ < frame.width && y_ < frame.height), occluder(INFINITY) {
    if (extras && inside && frame.occluder.data) occluder = frame.occluder_at(std::size_t(x), std::size_t(y));
  }
};

/// 32 bytes in two loads.
__device__ inline SplatShape load_shape(const SplatsView& splats, std::uint32_t id) {
  const float4* words = reinterpret_cast<const float4*>(splats.shapes.data + id);
  const float4 a = words[0], b = words[1];
  SplatShape shape;
  shape.mean = vec2(a.x, a.y), shape.l0 = a.z, shape.l1 = a.w;
  shape.l2 = b.x, shape.opacity = b.y, shape.cutoff = b.z, shape.low = __float_as_uint(b.w);
  return shape;
}

/// RGB and depth in one load.
__device__ inline float4 load_colour(const RasterJob& job, std::uint32_t id) {
  return *reinterpret_cast<const float4*>(job.colours.each.data + id);
}

/// Whether no pixel shows the splat of a loaded colour.
__device__ inline bool is_colourless(const float4& colour) { return !(colour.w > 0); }

/// Whether some view of `job` has to remember splats.
inline bool some_view_picks(const RasterJob& job) {
  return std::any_of(job.views.begin(), job.views.end(), [&](const View& view) { return job.picks(view); });
}

/// Whether some view of `job` has to sum attributes or to remember splats.
inline bool sums_or_picks(const RasterJob& job) { return job.attributes.rows != 0 || some_view_picks(job); }

/// Whether some view of `job` has to sum depths or to hide splats by them.
inline bool some_view_has_depth(const RasterJob& job) {
  return std::any_of(job.views.begin(), job.views.end(),
                     [&](const View& view) { return job.sums_depth(view) || view.frame.occluder.data; });
}

/// Whether `job` asks for more than colour and alpha.
inline bool asks_for_planes(const RasterJob& job) { return sums_or_picks(job) || some_view_has_depth(job); }

/// Copies of the views in which a view that converts colours draws unconverted ones to memory of the backend.
/// A single such view is `one`.
SWIFTGS_API Views redirect_colours(Cuda& cuda, const Views& views, View& one);
/// Converts the colours in that memory and writes them to the frames of `job`.
SWIFTGS_API void convert_colours(Cuda& cuda, const RasterJob& job);

inline bool some_view_converts(const RasterJob& job) {
  return !job.only_attributes && std::any_of(job.views.begin(), job.views.end(), [](const View& view) {
    return view.frame.colour.data && view.frame.conversion != Conversion::as_is;
  });
}

/// Calls f(input). Throws as `raster_blocks_of`.
template <class F>
void with_raster_input(Cuda& cuda, const RasterJob& job, const F& f) {
  View one;
  const bool converts = some_view_converts(job);
  const Views views = converts ? redirect_colours(cuda, job.views, one) : job.views;
  const RasterBlocks raster_blocks = raster_blocks_of(job);
  const std::uint32_t* const order = order_raster_blocks(cuda, job.lists, raster_blocks);
  with_views(views, [&]<class ViewSource>(const ViewSource& source) {
    f(RasterInput<ViewSource>{job, source, raster_blocks, order});
  });
  if (converts) convert_colours(cuda, job);
}

/// Starts the kernel `Kernel::of<planes, ViewSource>` of a rasterizer on all raster blocks of `job`.
template <class Kernel>
void launch_raster_blocks(Cuda& cuda, const char* name, const RasterJob& job, bool planes) {
  with_raster_input(cuda, job, [&]<class ViewSource>(const RasterInput<ViewSource>& input) {
    const auto kernel =
        planes ? Kernel::template of<true, ViewSource> : Kernel::template of<false, ViewSource>;
    launch(name, kernel, blocks_of(input.raster_blocks), Kernel::threads, cuda.stream(), input);
  });
}

}  // namespace swiftgs::kernels
