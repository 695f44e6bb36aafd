// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

#include <swiftgs/cuda/raster_block.cuh>
#include <swiftgs/cuda/warp.cuh>
#include <swiftgs/frame/raster.hpp>

#include "blending.hpp"

namespace swiftgs::kernels {

/// Place of a pixel in a frame, and the depth at which the frame's occluder hides splats.
struct PixelPlace {
  int x, y;
  bool inside;
  float occluder;  ///< depth of what hides the splats behind it

  __device__ PixelPlace(const FrameView& frame, int x_, int y_, bool extras)
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
__device__ inline bool is_hidden(const float4& colour) { return !(colour.w > 0); }

}  // namespace swiftgs::kernels
