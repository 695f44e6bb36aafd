// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include <swiftgs/frame/passes.hpp>

#include "accumulators.cuh"

namespace swiftgs::kernels {

/// Occluders that hide by depths along the ray. Volatile, so in memory: few frames need it, and the loop over
/// splats needs the registers. With registers, frames of fox and herz with normals take 13 % longer (measured
/// on an H100).
template <unsigned pixel_count>
struct LaneRays<true, pixel_count> {
  const AttributeRow* volatile depths;  ///< of all splats; null where means decide
  volatile unsigned stride;             ///< from one splat's to the next
  volatile float x, y;                  ///< `point_of` the first pixel
  volatile float occluders[pixel_count];

  __device__ LaneRays(const RasterJob& job, const View& view)
      : depths(hides_along_ray(view) ? job.attributes.first_row : nullptr),
        stride(job.attributes.first_stride) {}

  /// Tells where the first pixel lies in the frame.
  __device__ void put(const View& view, int x_in_frame, int y_in_frame) {
    const vec2 point = point_of(view, std::size_t(x_in_frame), std::size_t(y_in_frame));
    x = point.x, y = point.y;
  }
  /// Takes the occluder of the p-th pixel. Returns the one for depths of means; along the ray this is
  /// -infinity, so that every splat is tested here.
  __device__ float take(unsigned p, float occluder) {
    occluders[p] = occluder;
    return depths ? -INFINITY : occluder;
  }

  /// Whether the p-th pixel does not show a splat.
  __device__ bool hide(std::uint32_t id, unsigned p) const {
    const float4 row = *reinterpret_cast<const float4*>(depths + std::size_t(id) * stride);
    const vec2 point(x + float(p * columns_between), y);
    // A variable index would have all that a lane holds in memory.
    const float occluder = p == 0 ? occluders[0] : occluders[pixel_count - 1];
    return RayDepth{row.x, row.y, row.z}.at(point) >= occluder;
  }
};

}  // namespace swiftgs::kernels
