// SPDX-License-Identifier: Apache-2.0
#include "planes.hpp"
#include "raster_segments.cuh"

namespace swiftgs {

namespace {
/// Whether kernels of colour and of depths of means draw all of `job`.
bool is_of_colour(const RasterJob& job) { return !kernels::sums_or_picks(job) && !kernels::keeps_faint(job); }
}  // namespace

void rasterize(Cuda& cuda, AxisShared<FloatCholesky>, const RasterJob& job) {
  const char* const name = "rasterize axis-shared-float-cholesky";
  if (is_of_colour(job)) return kernels::rasterize_colour<kernels::CholeskyExponent, false>(cuda, name, job);
  kernels::rasterize_planes<false>(cuda, name, job);
}
void rasterize(Cuda& cuda, AxisSharedThreshold<FloatCholesky>, const RasterJob& job) {
  const char* const name = "rasterize axis-shared-threshold-float-cholesky";
  if (is_of_colour(job)) return kernels::rasterize_colour<kernels::CholeskyExponent, true>(cuda, name, job);
  kernels::rasterize_planes<true>(cuda, name, job);
}

}  // namespace swiftgs
