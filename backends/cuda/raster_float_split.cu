// SPDX-License-Identifier: Apache-2.0
#include <swiftgs/cuda/features.hpp>

#include "along_ray.cuh"
#include "other_exponents.hpp"
#include "planes.hpp"
#include "raster_segments.cuh"

namespace swiftgs {

namespace kernels {
namespace {
template <bool threshold>
void rasterize_split(Cuda& cuda, const char* name, const RasterJob& job) {
  rasterize_few<threshold>(cuda, name, job, [&](const RasterJob& few) {
    if (some_view_hides_along_ray(few) || keeps_faint(few))
      rasterize_warps<SplitExponent, threshold, PixelPlanes<Depths::of_rays>>(cuda, name, few);
    else
      rasterize_colour<SplitExponent, threshold>(cuda, name, few);
  });
}
}  // namespace
}  // namespace kernels

void rasterize(Cuda& cuda, AxisShared<FloatSplit>, const RasterJob& job) {
  kernels::rasterize_split<false>(cuda, "rasterize axis-shared-float-split", job);
}
void rasterize(Cuda& cuda, AxisSharedThreshold<FloatSplit>, const RasterJob& job) {
  kernels::rasterize_split<true>(cuda, "rasterize axis-shared-threshold-float-split", job);
}

}  // namespace swiftgs
