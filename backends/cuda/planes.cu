// SPDX-License-Identifier: Apache-2.0
#include "along_ray.cuh"
#include "pick.cuh"
#include "planes.hpp"
#include "raster_segments.cuh"
#include "sum.cuh"

namespace swiftgs::kernels {

template <bool threshold>
void rasterize_planes(Cuda& cuda, const char* name, const RasterJob& job) {
  const auto rasterize = [&]<Depths depths, class... Accumulators>(const RasterJob& of) {
    rasterize_warps<CholeskyExponent, threshold, PixelPlanes<depths, Accumulators...>>(cuda, name, of);
  };
  using enum Depths;
  const unsigned rows = job.attributes.rows;
  if (!some_view_picks(job) && rows != 0)
    return rows == 1 ? rasterize.template operator()<of_rays, Sum<1>>(job)
                     : rasterize.template operator()<of_rays, Sum<AttributesView::most_rows>>(job);
  if (rows == 1) return rasterize.template operator()<of_rays, Pick, Sum<1>>(job);
  // There are no registers for picks and several rows: these are drawn behind them.
  if (some_view_hides_along_ray(job))
    rasterize.template operator()<of_rays, Pick>(job);
  else
    rasterize.template operator()<of_means, Pick>(job);
  if (rows == 0) return;
  RasterJob behind = job;
  behind.only_attributes = true;
  rasterize_planes<threshold>(cuda, name, behind);
}

template void rasterize_planes<false>(Cuda&, const char*, const RasterJob&);
template void rasterize_planes<true>(Cuda&, const char*, const RasterJob&);

}  // namespace swiftgs::kernels
