// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Planes that sum attributes of splats by weight, as colour does: depth along the ray, normal, squared depth
/// and features. Each of their channels is an attribute. Rasterizers sum rows of four attributes, whatever
/// they mean.

#include <cstddef>
#include <cstdint>

#include <swiftgs/frame.hpp>
#include <swiftgs/math.hpp>
#include <swiftgs/plane/ray_depth.hpp>
#include <swiftgs/raster/passes.hpp>
#include <swiftgs/views.hpp>

namespace swiftgs {

/// A channel of a plane.
struct Attribute {
  enum class Of { nothing, ray_depth, normal, squared_depth, squared_ray_depth, feature } of = Of::nothing;
  int channel = 0;
};

/// The k-th attribute of `view` for `planes`, a `Request` or a `FrameView`.
template <class Planes>
SWIFTGS_HD Attribute attribute(const View& view, const Planes& planes, int k) {
  if (takes_ray_depth(view, planes)) {
    if (k < RayDepth::terms) return {Attribute::Of::ray_depth, k};
    k -= RayDepth::terms;
  }
  if (planes.normal) {
    if (k < 3) return {Attribute::Of::normal, k};
    k -= 3;
  }
  if (planes.squared_depth) {
    const bool along_ray = view.camera.depth_along_ray;
    const int channels = along_ray ? RayDepth::squares : 1;
    if (k < channels) return {along_ray ? Attribute::Of::squared_ray_depth : Attribute::Of::squared_depth, k};
    k -= channels;
  }
  if (planes.features && k < view.frame.feature_channels) return {Attribute::Of::feature, k};
  return {};
}

/// Largest magnitude that is summed: devices sum in units of alpha_max, and no sum may be infinite.
SWIFTGS_HD constexpr float most_attribute(float alpha_max) { return 3.4e38f * alpha_max; }

/// Writes the planes of attributes at column x of row y, by their sums.
SWIFTGS_HD inline void store_attributes(const View& view, const AttributesView& attributes, std::size_t x,
                                        std::size_t y, float transmittance, const float* sums) {
  const FrameView& frame = view.frame;
  const float alpha = 1 - transmittance;
  const auto mean = [&](float sum) { return alpha > 0 ? sum / alpha : 0.0f; };
  for (unsigned i = 0; i < attributes.rows * AttributeRow::channels; ++i) {
    const Attribute to = attribute(view, frame, attributes.first + int(i));
    if (to.of == Attribute::Of::nothing) return;
    if (to.of == Attribute::Of::ray_depth) {
      const RayDepth sum{sums[i], sums[i + 1], sums[i + 2]};
      if (frame.depth.data) frame.depth.row(y)[x] = mean(sum.at(place_of(view, x, y)));
      i += RayDepth::terms - 1;
    } else if (to.of == Attribute::Of::squared_ray_depth) {
      frame.squared_depth.row(y)[x] = mean(sum_of_squares(sums + i, place_of(view, x, y)));
      i += RayDepth::squares - 1;
    } else if (to.of == Attribute::Of::normal) {
      frame.normal.row(y)[3 * x + std::size_t(to.channel)] = sums[i];
    } else if (to.of == Attribute::Of::squared_depth) {
      frame.squared_depth.row(y)[x] = mean(sums[i]);
    } else {
      float* const feature =
          frame.features.row(y) + x * std::size_t(frame.feature_channels) + std::size_t(to.channel);
      const bool as_row = i % AttributeRow::channels == 0 &&
                          to.channel + int(AttributeRow::channels) <= frame.feature_channels &&
                          reinterpret_cast<std::uintptr_t>(feature) % alignof(AttributeRow) == 0;
      if (as_row) {  // one store: a device writes memory by 32 bytes, however little of them it is given
        *reinterpret_cast<AttributeRow*>(feature) = {{sums[i], sums[i + 1], sums[i + 2], sums[i + 3]}};
        i += AttributeRow::channels - 1;
      } else {
        *feature = sums[i];
      }
    }
  }
}

}  // namespace swiftgs
