// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <vector>

#include <swiftgs/cuda/raster_block.cuh>
#include <swiftgs/cuda/stages.hpp>

namespace swiftgs::kernels {

/// Whether some view has an occluder that hides by depths along the ray.
inline bool some_view_hides_along_ray(const RasterJob& job) {
  return std::any_of(job.views.begin(), job.views.end(), hides_along_ray);
}

/// Whether alphas far below 1/255 are kept of a view that is not stored. The helper kernels of colour and of
/// depth of means then lack a branch.
inline bool keeps_faint(const RasterJob& job) {
  return !job.views.stored && !keeps_digits(job.views[0].rules.log2_relative_min);
}

/// Rasterizes with what pixels remember and sum, by the kernels of `FloatCholesky`.
template <bool threshold>
void rasterize_planes(Cuda& cuda, const char* name, const RasterJob& job);

/// Whether `job` asks for more than colour, alpha and depths of means.
inline bool has_further_planes(const RasterJob& job) {
  const auto asks = [](const View& view) {
    return attribute_count(view) > (asks_for_ray_depth(view) ? RayDepth::terms : 0) ||
           (view.camera.depth_along_ray && view.frame.depth.data);
  };
  return some_view_picks(job) ||
         (job.attributes.rows != 0 && std::any_of(job.views.begin(), job.views.end(), asks));
}

/// Copies of the views, in `each`, without colour, alpha and depths of means.
Views further_planes_of(Cuda& cuda, const Views& views, std::vector<View>& each);

/// Rasterizes by draw(job), which draws colour, alpha and depths of means. Further planes are those of
/// `FloatCholesky`, behind these.
template <bool threshold, class F>
void rasterize_few(Cuda& cuda, const char* name, const RasterJob& job, const F& draw) {
  if (job.only_attributes) return rasterize_planes<threshold>(cuda, name, job);
  draw(job);
  if (!has_further_planes(job)) return;
  std::vector<View> each;
  RasterJob further = job;
  further.views = further_planes_of(cuda, job.views, each);
  rasterize_planes<threshold>(cuda, name, further);
}

}  // namespace swiftgs::kernels
