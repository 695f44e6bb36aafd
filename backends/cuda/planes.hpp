// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/raster_block.cuh>

namespace swiftgs {

namespace kernels {
/// Whether the kernels of planes draw `job`: they alone sum attributes, remember splats, and take alphas far
/// below 1/255 of a view that is not stored.
inline bool takes_planes(const RasterJob& job) {
  return sums_or_picks(job) || (!job.views.stored && !keeps_digits(job.views[0].rules.log2_relative_min));
}
}  // namespace kernels

/// Rasterizes with what pixels remember and sum.
template <class Exponent, bool threshold>
void rasterize_planes(Cuda& cuda, const char* name, const RasterJob& job);

}  // namespace swiftgs
