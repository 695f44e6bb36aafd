// SPDX-License-Identifier: Apache-2.0
#include "raster_segments.cuh"

namespace swiftgs {

void rasterize(Cuda& cuda, AxisShared<FloatSplit>, const RasterJob& job) {
  rasterize_warps<kernels::SplitExponent, false>(cuda, "rasterize axis-shared-float-split", job);
}
void rasterize(Cuda& cuda, AxisSharedThreshold<FloatSplit>, const RasterJob& job) {
  rasterize_warps<kernels::SplitExponent, true>(cuda, "rasterize axis-shared-threshold-float-split", job);
}

}  // namespace swiftgs
