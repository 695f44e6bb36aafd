// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

#include <swiftgs/cuda/warp.cuh>
#include <swiftgs/raster/raster.hpp>

#include "blending.hpp"

namespace swiftgs::kernels {

/// What a frame wants beside colour and alpha. Kernels that know of neither are compiled apart.
inline bool wants_extras(const RasterJob& job, const FrameView& frame) {
  return frame.depth.data || frame.occluder.data || job.counts;
}

/// Where a pixel lies, and what a frame asks of it beside colour.
struct PixelPlace {
  int x, y;
  bool inside;
  float occluder;  ///< camera-space z of what hides the splats behind it

  __device__ PixelPlace(const FrameView& frame, int x_, int y_, bool extras)
      : x(x_), y(y_), inside(x_ < frame.width && y_ < frame.height), occluder(INFINITY) {
    if (extras && inside && frame.occluder.data) occluder = frame.occluder.row(std::size_t(y))[x];
  }
};

/// A block for each square of a frame, in columns and rows as they lie in the image: no thread divides.
inline dim3 blocks_for(const FrameView& frame) {
  const Squares squares(frame);
  return dim3(unsigned(squares.columns), unsigned(squares.rows));
}

/// The square of this block: its number and its first pixel.
struct BlockSquare {
  __device__ static std::uint32_t number() { return blockIdx.y * gridDim.x + blockIdx.x; }
  __device__ static int x() { return int(blockIdx.x) * square_side; }
  __device__ static int y() { return int(blockIdx.y) * square_side; }

  /// Where its list is. From the block's index alone: a compiler that sees the same range for all threads
  /// spares loops over it the code for diverged warps, which is 3 % of a long list.
  __device__ static TileRange list(const RasterJob& job, const View& view) {
    return job.lists.ranges[view.grid.tile_at(x(), y())];
  }
};

/// Adds what a warp counted to its square.
__device__ inline void add_counts(SquareCounts* counts, const ThreadCounts& mine, std::uint32_t instances,
                                  std::uint32_t pixels) {
  using Word = unsigned long long;
  const auto field = [&](std::uint64_t SquareCounts::*member) {
    return reinterpret_cast<Word*>(&(counts[BlockSquare::number()].*member));
  };
  const std::uint32_t pairs = warp_sum(mine.pairs), stopped = warp_sum(mine.stopped);
  if (lane_index() != 0) return;
  atomicMax(field(&SquareCounts::instances_visited), Word(instances));
  atomicAdd(field(&SquareCounts::rows_visited), Word(pixels / square_side));
  atomicAdd(field(&SquareCounts::contributing_pairs), Word(pairs));
  atomicAdd(field(&SquareCounts::pixels_stopped), Word(stopped));
}

/// 32 bytes in two loads.
__device__ inline SplatShape load_shape(const RasterJob& job, std::uint32_t id) {
  const float4* words = reinterpret_cast<const float4*>(job.splats.shapes.data + id);
  const float4 a = words[0], b = words[1];
  SplatShape shape;
  shape.mean = vec2(a.x, a.y), shape.l0 = a.z, shape.l1 = a.w;
  shape.l2 = b.x, shape.opacity = b.y, shape.reach = b.z, shape.half_width = b.w;
  return shape;
}

/// RGB and depth in one load.
__device__ inline float4 load_colour(const RasterJob& job, std::uint32_t id) {
  return *reinterpret_cast<const float4*>(job.colours.each.data + id);
}

/// Whether no pixel shows the splat of a loaded colour.
__device__ inline bool is_hidden(const float4& colour) { return !(colour.w > 0); }

}  // namespace swiftgs::kernels
