// SPDX-License-Identifier: Apache-2.0

// The rasterizers of the library that have no kernels of their own.
#include <tuple>

#include <swiftgs/cuda.cuh>

namespace swiftgs {

template <LibraryRaster R>
void rasterize(Cuda& cuda, R, const RasterJob& job) {
  kernels::run_raster_pixels<R>(cuda, job);
}

namespace {

template <class R>
using Rasterize = void (*)(Cuda&, R, const RasterJob&);

template <class... Rasters>
std::tuple<Rasterize<Rasters>...> rasterizers_of(TypeList<Rasters...>) {
  return {static_cast<Rasterize<Rasters>>(&rasterize)...};
}

/// Addresses of overloads where there are any, and of instances of the template for the others.
[[gnu::used]] const auto instantiated = rasterizers_of(AllRasters{});

}  // namespace
}  // namespace swiftgs
