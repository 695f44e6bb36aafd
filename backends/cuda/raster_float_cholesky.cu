// SPDX-License-Identifier: Apache-2.0
#include "raster_segments.cuh"

namespace swiftgs {

void rasterize(Cuda& cuda, AxisShared<FloatCholesky>, const RasterJob& job) {
  rasterize_warps<kernels::CholeskyExponent, false>(cuda, "rasterize axis-shared-float-cholesky", job);
}
void rasterize(Cuda& cuda, AxisSharedThreshold<FloatCholesky>, const RasterJob& job) {
  rasterize_warps<kernels::CholeskyExponent, true>(cuda, "rasterize axis-shared-threshold-float-cholesky",
                                                   job);
}

}  // namespace swiftgs
