// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <tuple>

#include <swiftgs/backend.hpp>
#include <swiftgs/plane/attributes.hpp>
#include <swiftgs/plane/normal.hpp>
#include <swiftgs/plane/ray_depth.hpp>
#include <swiftgs/raster/raster.hpp>
#include <swiftgs/scene.hpp>
#include <swiftgs/splats.hpp>
#include <swiftgs/tiles.hpp>
#include <swiftgs/views.hpp>

namespace swiftgs {

/// The attributes of splats that a stage gathers. Pointers are to memory that the backend reaches.
struct SplatAttributes {
  SceneView scene;
  SplatsView splats;
  int first = 0;      ///< attribute of the frame
  unsigned rows = 0;  ///< of `AttributesView`

  /// Writes the rows of splat `i`, which `view` shows.
  SWIFTGS_HD void gather(const View& view, std::size_t i, AttributeRow* to) const {
    RayDepth along_ray;
    if (first == 0 && takes_ray_depth(view))
      along_ray = ray_depth(view.camera, gaussian(scene, splats.gaussians[i]), splats.shapes[i].mean,
                            splats.depths[i], most_attribute(view.rules.alpha_max));
    for (unsigned r = 0; r < rows; ++r) to[r * splats.size() + i] = row(view, r, i, along_ray);
  }

 private:
  /// What is not finite counts as 0. Larger magnitudes than `most_attribute` are cut to it.
  SWIFTGS_HD AttributeRow row(const View& view, unsigned r, std::size_t i, const RayDepth& along_ray) const {
    const float largest = 3.4028234663852886e38f, most = most_attribute(view.rules.alpha_max);
    const float depth = splats.depths[i];
    const std::size_t id = splats.gaussians[i];
    AttributeRow out;
    vec3 normal(0);
    for (unsigned c = 0; c < AttributeRow::channels; ++c) {
      const Attribute from = attribute(view, first + int(r * AttributeRow::channels + c));
      float value = 0;
      switch (from.of) {
        case Attribute::Of::ray_depth:
          value = from.channel == 0 ? along_ray.middle : from.channel == 1 ? along_ray.x : along_ray.y;
          break;
        case Attribute::Of::squared_ray_depth:
          value = along_ray.square(from.channel);
          break;
        case Attribute::Of::normal:
          if (c == 0 || from.channel == 0) normal = splat_normal(view.camera, scene, id);
          value = normal[from.channel];
          break;
        case Attribute::Of::squared_depth:
          value = depth * depth < most ? depth * depth : most;  // it may be infinite
          break;
        case Attribute::Of::feature:
          value = scene.features[id * std::size_t(scene.feature_channels) + std::size_t(from.channel)];
          break;
        case Attribute::Of::nothing:
          break;
      }
      const bool finite = value >= -largest && value <= largest;
      out.values[c] = !finite ? 0.0f : value < -most ? -most : value > most ? most : value;
    }
    return out;
  }
};

struct GatherAttributes {
  SplatAttributes from;
  const View* views;
  AttributeRow* to;

  void operator()(std::size_t i) const { from.gather(views[from.splats.view(i)], i, to); }
};

/// Writes attributes of all splats to `to`, @shape{rows, splats}, on hosts. A device overloads this.
template <BackendPolicy B>
requires(bool(B::reaches_host_memory)) void gather_attributes(B& b, const SplatAttributes& from,
                                                              const Views& views, AttributeRow* to) {
  b.for_each(from.splats.count(), GatherAttributes{from, views.each.data, to});
}

/// Most attributes that one view asks for.
inline int attribute_count(Span<const View> views) {
  int most = 0;
  for (const View& view : views) most = std::max(most, attribute_count(view));
  return most;
}

/// Devices sum depths along the ray, but do not find that of one splat at a pixel. Throws
/// `std::invalid_argument` for views that need it.
inline void refuse_pixels_along_ray(Span<const View> views) {
  for (std::size_t i = 0; i < views.size; ++i) {
    const FrameView& frame = views[i].frame;
    if (views[i].camera.depth_along_ray &&
        (frame.occluder.data || frame.first_depth.data || frame.median_depth.data))
      throw std::invalid_argument("render: view " + std::to_string(i) +
                                  " has an occluder, first or median depths along the ray, expected depths "
                                  "of centres for these on a device");
  }
}

/// Rasterizes frames that may ask for attributes.
template <class B>
class AttributeStage {
 public:
  /// Calls rasterize(job) as often as it takes: once for frames of up to `AttributesView::most` attributes.
  template <class Rasterize>
  void draw(B& b, const SceneView& scene, RasterJob job, const Rasterize& rasterize) {
    const int count = attribute_count(job.views.each), most = int(AttributesView::most);
    if constexpr (!B::reaches_host_memory) refuse_pixels_along_ray(job.views.each);
    // A device's kernels that count know nothing of attributes.
    const bool counts_apart = job.counts && !B::reaches_host_memory;
    if (count == 0 || counts_apart) rasterize(job);
    if (counts_apart) job.counts = nullptr, job.only_attributes = true;
    each_.reset(AttributesView::kept_rows_for(count) * job.splats.size());
    for (int first = 0; first < count; first += most, job.counts = nullptr, job.only_attributes = true) {
      const SplatAttributes from{scene, job.splats, first, AttributesView::rows_for(count - first)};
      AttributeRow* const rows = each_.data() + (first == 0 ? 0 : job.splats.size());
      gather_attributes(b, from, job.views, rows);
      job.attributes = {rows, job.splats.size(), from.rows, first, each_.data()};
      rasterize(job);
    }
  }

  /// Takes the memory of such frames, on hosts.
  void reserve(const Views& views, const Reservation& reserved) {
    const unsigned rows = AttributesView::kept_rows_for(attribute_count(views.each));
    if (rows != 0) each_.reset_exactly(rows * reserved.capacity.splats);
  }

  static auto buffers(auto& self) { return std::tie(self.each_); }

 private:
  typename B::template Buffer<AttributeRow> each_;
};

}  // namespace swiftgs
