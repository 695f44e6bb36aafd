// SPDX-License-Identifier: Apache-2.0
#include "pick.cuh"
#include "planes.hpp"

#include <algorithm>
#include "raster_segments.cuh"
#include "sum.cuh"

namespace swiftgs {

template <class Exponent, bool threshold>
void rasterize_planes(Cuda& cuda, const char* name, const RasterJob& job) {
  using namespace kernels;
  const auto rasterize = [&]<Depths depths, class... Accumulators>(const RasterJob& of) {
    rasterize_warps<Exponent, threshold, PixelPlanes<depths, Accumulators...>>(cuda, name, of);
  };
  using enum Depths;
  const unsigned rows = job.attributes.rows;
  if (!some_view_picks(job) && rows != 0)
    return rows == 1 ? rasterize.template operator()<of_rays, Sum<1>>(job)
                     : rasterize.template operator()<of_rays, Sum<AttributesView::most_rows>>(job);
  if (rows == 1) return rasterize.template operator()<of_rays, Pick, Sum<1>>(job);
  // There are no registers for picks and several rows: these are drawn behind them.
  const bool along_ray = std::any_of(job.views.begin(), job.views.end(), hides_along_ray);
  if (rows != 0 && along_ray)
    rasterize.template operator()<of_rays, Pick>(job);
  else
    rasterize.template operator()<of_means, Pick>(job);
  if (rows == 0) return;
  RasterJob behind = job;
  behind.only_attributes = true;
  rasterize_planes<Exponent, threshold>(cuda, name, behind);
}

template void rasterize_planes<kernels::CholeskyExponent, false>(Cuda&, const char*, const RasterJob&);
template void rasterize_planes<kernels::CholeskyExponent, true>(Cuda&, const char*, const RasterJob&);
template void rasterize_planes<kernels::SplitExponent, false>(Cuda&, const char*, const RasterJob&);
template void rasterize_planes<kernels::SplitExponent, true>(Cuda&, const char*, const RasterJob&);

}  // namespace swiftgs
