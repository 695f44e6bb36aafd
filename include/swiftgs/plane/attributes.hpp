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
#include <swiftgs/view.hpp>

namespace swiftgs {

/// A channel of a plane.
struct Attribute {
  enum class Of { nothing, ray_depth, normal, squared_depth, squared_ray_depth, feature } of = Of::nothing;
  int channel = 0;
};

/// Whether pixels of `view` need depths along their rays: its first attributes are then those of `RayDepth`.
SWIFTGS_HD inline bool takes_ray_depth(const View& view) {
  const FrameView& frame = view.frame;
  return view.camera.depth_along_ray &&
         (frame.depth.data || frame.squared_depth.data || frame.first_depth.data || frame.median_depth.data ||
          frame.occluder.data);
}

/// Whether `view` has an occluder that hides splats by their depths along the ray. These do not ascend in a
/// list, so that a pixel skips a hidden splat, where by the depths of means it ends.
SWIFTGS_HD inline bool hides_along_ray(const View& view) {
  return view.camera.depth_along_ray && view.frame.occluder.data;
}

/// Attributes that a view asks for.
SWIFTGS_HD inline int attribute_count(const View& view) {
  const FrameView& frame = view.frame;
  const int squared = view.camera.depth_along_ray ? RayDepth::squares : 1;
  return (takes_ray_depth(view) ? RayDepth::terms : 0) + (frame.normal.data ? 3 : 0) +
         (frame.squared_depth.data ? squared : 0) + (frame.features.data ? frame.feature_channels : 0);
}
/// The k-th of them.
SWIFTGS_HD inline Attribute attribute(const View& view, int k) {
  const FrameView& frame = view.frame;
  if (takes_ray_depth(view)) {
    if (k < RayDepth::terms) return {Attribute::Of::ray_depth, k};
    k -= RayDepth::terms;
  }
  if (frame.normal.data) {
    if (k < 3) return {Attribute::Of::normal, k};
    k -= 3;
  }
  if (frame.squared_depth.data) {
    const bool along_ray = view.camera.depth_along_ray;
    const int channels = along_ray ? RayDepth::squares : 1;
    if (k < channels) return {along_ray ? Attribute::Of::squared_ray_depth : Attribute::Of::squared_depth, k};
    k -= channels;
  }
  if (frame.features.data && k < frame.feature_channels) return {Attribute::Of::feature, k};
  return {};
}

/// Largest magnitude that is summed: devices sum in units of alpha_max, and no sum may be infinite.
SWIFTGS_HD constexpr float most_attribute(float alpha_max) { return 3.4e38f * alpha_max; }

/// Four attributes of a splat, in one 16-byte load.
struct alignas(16) AttributeRow {
  static constexpr unsigned channels = 4;
  float values[channels] = {};
};

/// Attributes that are rasterized together: @shape{splats, rows}. A frame that asks for more is rasterized
/// several times.
struct AttributesView {
  static constexpr unsigned most_rows = 4, most = most_rows * AttributeRow::channels;
  /// Rows that so many attributes take.
  static constexpr unsigned rows_for(int attributes) {
    const int count = attributes < 0 ? 0 : attributes < int(most) ? attributes : int(most);
    return (unsigned(count) + AttributeRow::channels - 1) / AttributeRow::channels;
  }

  /// Rows that a frame of so many attributes keeps: the first of each splat beside while later ones are
  /// drawn.
  static constexpr unsigned kept_rows_for(int attributes) {
    return rows_for(attributes) + (attributes > int(most) ? 1 : 0);
  }

  const AttributeRow* data = nullptr;
  unsigned rows = 0;  ///< at most `most_rows`; behind the last attribute of a frame are zeros
  int first = 0;      ///< attribute of the frame that is the first here
  /// The frame's first row, whatever is the first here: holds the `RayDepth` of splats whose view takes it.
  const AttributeRow* first_row = nullptr;
  unsigned first_stride = 0;  ///< rows from that of a splat to that of the next

  SWIFTGS_HD const AttributeRow& row(unsigned r, std::size_t splat) const { return data[splat * rows + r]; }
  SWIFTGS_HD RayDepth ray_depth(std::size_t splat) const {
    const float* const values = first_row[splat * first_stride].values;
    return {values[0], values[1], values[2]};
  }
  /// Adds those of a splat of this weight to `sums`.
  SWIFTGS_HD void add(float (&sums)[most], std::size_t splat, float weight) const {
    for (unsigned r = 0; r < rows; ++r)
      for (unsigned c = 0; c < AttributeRow::channels; ++c)
        sums[r * AttributeRow::channels + c] += weight * row(r, splat).values[c];
  }
};

/// Writes the planes of attributes at column x of row y, by their sums.
SWIFTGS_HD inline void store_attributes(const View& view, const AttributesView& attributes, std::size_t x,
                                        std::size_t y, float transmittance, const float* sums) {
  const FrameView& frame = view.frame;
  const float alpha = 1 - transmittance;
  const auto mean = [&](float sum) { return alpha > 0 ? sum / alpha : 0.0f; };
  for (unsigned i = 0; i < attributes.rows * AttributeRow::channels; ++i) {
    const Attribute to = attribute(view, attributes.first + int(i));
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
