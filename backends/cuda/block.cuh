// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <swiftgs/cuda/raster_block.cuh>
#include <swiftgs/cuda/warp.cuh>
#include <swiftgs/plane/attributes.hpp>
#include <swiftgs/plane/picks.hpp>

#include "blending.hpp"

namespace swiftgs {

namespace kernels {
inline constexpr unsigned block_threads = raster_block_side * raster_block_side;

/// The pixel of this thread, where a thread block blends a raster block and each thread loads splats for all.
/// With `depth` it sums depths and occluders hide by them, with `planes` it picks and sums attributes too.
template <bool depth, bool planes, class ViewSource>
struct RasterBlockPixel {
  const RasterInput<ViewSource>& input;
  OwnRasterBlock raster_block;
  FramePixel at;
  Pixel pixel;
  SplatPicks picks;
  float sums[AttributesView::most]{};  ///< of attributes

  __device__ explicit RasterBlockPixel(const RasterInput<ViewSource>& of)
      : input(of),
        raster_block(of),
        at(view().frame, raster_block.x + column(), raster_block.y + row(), depth) {
    if (at.inside) pixel.start(view().rules.stop_below);
  }

  __device__ const View& view() const { return input.views[raster_block.view]; }

  __device__ static int column() { return int(threadIdx.x % raster_block_side); }
  __device__ static int row() { return int(threadIdx.x / raster_block_side); }
  /// In the image.
  __device__ vec2 first_centre() const {
    return vec2(float(view().left() + raster_block.x) + 0.5f, float(view().top() + raster_block.y) + 0.5f);
  }

  __device__ vec2 ray_point() const { return point_of(view(), std::size_t(at.x), std::size_t(at.y)); }

  /// Whether no pixel of the raster block is left that could show another splat. A barrier of the block.
  __device__ bool all_stopped() const { return __syncthreads_and(!pixel.live()) != 0; }

  /// Blends the splat whose id is `lists.ids[k]`.
  __device__ void blend(float alpha, const float4& colour, std::uint32_t k) {
    if constexpr (!depth) {
      kernels::blend<false>(pixel, alpha, Pixel::dimmed(pixel.transmittance, alpha), colour, INFINITY);
    } else {
      const RasterJob& job = input.job;
      const std::uint32_t id = job.lists.ids[k];
      const bool along_ray = hides_along_ray(view());
      if (along_ray && alpha > 0 && job.attributes.ray_depth(id).at(ray_point()) >= at.occluder) return;
      const float before = pixel.transmittance, left = Pixel::dimmed(before, alpha);
      kernels::blend<true>(pixel, alpha, left, colour, along_ray ? INFINITY : at.occluder);
      if constexpr (planes) {
        if (!(alpha > 0 && pixel.live())) return;
        job.attributes.add(sums, id, alpha * before);
        if (job.picks(view())) picks.offer(id, alpha * before, left, view().rules.first_below);
      }
    }
  }

  __device__ void store() const {
    const auto x = std::size_t(at.x), y = std::size_t(at.y);
    if (at.inside) {
      if constexpr (planes) {
        store_pixel(input.job, view(), x, y, pixel.blended(), sums);
        if (input.job.picks(view())) store_picks(input.job, view(), x, y, picks);
      } else {
        store_pixel(view().frame, x, y, pixel.blended(), view().background);
      }
    }
  }
};
}  // namespace kernels

}  // namespace swiftgs
