// SPDX-License-Identifier: Apache-2.0
#include "planes.hpp"
#include "raster_segments.cuh"

namespace swiftgs {

namespace {
template <bool threshold>
void rasterize_float(Cuda& cuda, const char* name, const RasterJob& job) {
  using Exponent = kernels::CholeskyExponent;
  kernels::takes_planes(job) ? rasterize_planes<Exponent, threshold>(cuda, name, job)
                             : rasterize_colour<Exponent, threshold>(cuda, name, job);
}
}  // namespace

void rasterize(Cuda& cuda, AxisShared<FloatCholesky>, const RasterJob& job) {
  rasterize_float<false>(cuda, "rasterize axis-shared-float-cholesky", job);
}
void rasterize(Cuda& cuda, AxisSharedThreshold<FloatCholesky>, const RasterJob& job) {
  rasterize_float<true>(cuda, "rasterize axis-shared-threshold-float-cholesky", job);
}

}  // namespace swiftgs
