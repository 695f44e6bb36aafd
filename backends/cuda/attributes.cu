// SPDX-License-Identifier: Apache-2.0
#include <cstddef>

#include <swiftgs/cuda/features.hpp>
#include <swiftgs/cuda/launch.cuh>
#include <swiftgs/cuda/view_source.cuh>
#include <swiftgs/plane/attribute_stage.hpp>

namespace swiftgs {

namespace kernels {
inline constexpr unsigned attribute_threads = 256;

/// One thread per splat.
template <bool along_ray, class ViewSource, class Scenes>
__global__ void __launch_bounds__(attribute_threads)
    gather_attributes(const __grid_constant__ SplatAttributes from, const __grid_constant__ ViewSource views,
                      const __grid_constant__ Scenes scenes, AttributeRow* to) {
  const std::size_t i = std::size_t(blockIdx.x) * blockDim.x + threadIdx.x;
  if (i >= from.splats.count().get()) return;
  from.gather<along_ray>(scenes, views[from.splats.view(i)], i, to);
}
}  // namespace kernels

void gather_attributes(Cuda& cuda, const SplatAttributes& from, const StoredScenes& scenes,
                       const Views& views, AttributeRow* to) {
  const std::size_t most = from.splats.size();
  if (most == 0) return;
  const auto run = [&]<class ViewSource, class Scenes>(const ViewSource& source, const Scenes& of) {
    const auto gather = [&](auto kernel) {
      launch("gather_attributes", kernel, blocks_for(most, kernels::attribute_threads),
             kernels::attribute_threads, cuda.stream(), from, source, of, to);
    };
    if (from.along_ray(views.each))
      gather(kernels::gather_attributes<true, ViewSource, Scenes>);
    else
      gather(kernels::gather_attributes<false, ViewSource, Scenes>);
  };
  kernels::with_views_and_scenes(views, scenes, run);
}

}  // namespace swiftgs
