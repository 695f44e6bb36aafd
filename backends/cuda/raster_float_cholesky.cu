// SPDX-License-Identifier: Apache-2.0
#include "planes.hpp"
#include "raster_segments.cuh"

namespace swiftgs {

namespace kernels {
namespace {
template <bool threshold>
void rasterize_cholesky(Cuda& cuda, const char* name, const RasterJob& job) {
  if (sums_or_picks(job) || keeps_faint(job)) return rasterize_planes<threshold>(cuda, name, job);
  rasterize_colour<CholeskyExponent, threshold>(cuda, name, job);
}
}  // namespace
}  // namespace kernels

void rasterize(Cuda& cuda, AxisShared<FloatCholesky>, const RasterJob& job) {
  kernels::rasterize_cholesky<false>(cuda, "rasterize axis-shared-float-cholesky", job);
}
void rasterize(Cuda& cuda, AxisSharedThreshold<FloatCholesky>, const RasterJob& job) {
  kernels::rasterize_cholesky<true>(cuda, "rasterize axis-shared-threshold-float-cholesky", job);
}

}  // namespace swiftgs
