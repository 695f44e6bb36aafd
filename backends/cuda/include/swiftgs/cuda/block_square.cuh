// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/launch.cuh>
#include <swiftgs/cuda/warp.cuh>
#include <swiftgs/raster/raster.hpp>

namespace swiftgs::kernels {

/// A block for each square of a frame, in columns and rows as they lie in the image: no thread divides.
inline dim3 blocks_for(const FrameView& frame) {
  const Squares squares(frame);
  return dim3(unsigned(squares.columns), unsigned(squares.rows));
}

/// Starts a rasterizer's kernel on all squares of the view of `job`, with its counts cleared.
template <class... Parameters, class... More>
void launch_squares(Cuda& cuda, const char* name, void (*kernel)(RasterJob, View, Parameters...),
                    unsigned threads, const RasterJob& job, const View& view, const More&... more) {
  if (job.counts) cuda.clear(job.counts, Squares(view.frame).size() * sizeof(SquareCounts));
  launch(name, kernel, blocks_for(view.frame), threads, cuda.stream(), job, view, more...);
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

/// Adds the counts of a warp to its square. The square has visited as many instances as the furthest of its
/// warps. Call it on a whole warp, with the same counts on all lanes.
__device__ inline void add_counts(SquareCounts& square, const SquareCounts& of_warp) {
  using Word = unsigned long long;
  const auto field = [&](std::uint64_t SquareCounts::*member) {
    return reinterpret_cast<Word*>(&(square.*member));
  };
  if (lane_index() != 0) return;
  atomicMax(field(&SquareCounts::instances_visited), Word(of_warp.instances_visited));
  atomicAdd(field(&SquareCounts::rows_visited), Word(of_warp.rows_visited));
  atomicAdd(field(&SquareCounts::contributing_pairs), Word(of_warp.contributing_pairs));
  atomicAdd(field(&SquareCounts::pixels_stopped), Word(of_warp.pixels_stopped));
}

}  // namespace swiftgs::kernels
