// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <tuple>
#include <utility>

#include <swiftgs/backend.hpp>
#include <swiftgs/plane/attributes.hpp>
#include <swiftgs/plane/normal.hpp>
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

  /// Row `r` of splat `i`, which `view` shows. What is not finite counts as 0. Larger magnitudes than
  /// `most_attribute` are cut to it.
  SWIFTGS_HD AttributeRow row(const View& view, unsigned r, std::size_t i) const {
    const float largest = 3.4028234663852886e38f, most = most_attribute(view.rules.alpha_max);
    const float depth = splats.depths[i];
    const std::size_t id = splats.gaussians[i];
    AttributeRow out;
    vec3 normal(0);
    for (unsigned c = 0; c < AttributeRow::channels; ++c) {
      const Attribute from = attribute(view.frame, first + int(r * AttributeRow::channels + c));
      float value = 0;
      switch (from.of) {
        case Attribute::Of::normal:
          if (from.channel == 0) normal = splat_normal(view.camera, scene, id);
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

  void operator()(std::size_t i) const {
    for (unsigned r = 0; r < from.rows; ++r)
      to[r * from.splats.size() + i] = from.row(views[from.splats.view(i)], r, i);
  }
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
  for (const View& view : views) most = std::max(most, attribute_count(view.frame));
  return most;
}

/// Rasterizes frames that may ask for attributes.
template <class B>
class AttributeStage {
 public:
  /// Calls rasterize(job) as often as it takes: once for frames of up to `AttributesView::most` attributes.
  template <class Rasterize>
  void draw(B& b, const SceneView& scene, RasterJob job, const Rasterize& rasterize) {
    const int count = attribute_count(job.views.each), most = int(AttributesView::most);
    // A device's kernels that count know nothing of attributes.
    if (count == 0 || job.counts) rasterize(job);
    job.only_attributes = std::exchange(job.counts, nullptr) != nullptr;
    for (int first = 0; first < count; first += most, job.only_attributes = true) {
      const SplatAttributes from{scene, job.splats, first, AttributesView::rows_for(count - first)};
      each_.reset(from.rows * job.splats.size());
      gather_attributes(b, from, job.views, each_.data());
      job.attributes = {each_.data(), job.splats.size(), from.rows, first};
      rasterize(job);
    }
  }

  /// Takes the memory of such frames, on hosts.
  void reserve(const Views& views, const Reservation& reserved) {
    const unsigned rows = AttributesView::rows_for(attribute_count(views.each));
    if (rows != 0) each_.reset_exactly(rows * reserved.capacity.splats);
  }

  static auto buffers(auto& self) { return std::tie(self.each_); }

 private:
  typename B::template Buffer<AttributeRow> each_;
};

}  // namespace swiftgs
