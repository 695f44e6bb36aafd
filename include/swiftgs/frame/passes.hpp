// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The rasterizations of a frame. Each sums colour, or rows of attributes, or both, over the same tile lists.

#include <algorithm>
#include <cstddef>

#include <swiftgs/frame/frame_view.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/frame/views.hpp>

namespace swiftgs {

/// Depth as a plane over the image. All splats measure from the middle of the image, so the weighted sum of
/// their planes is a plane too, and an image strip has the bits of the whole image.
struct RayDepth {
  static constexpr int terms = 3, squares = 6;

  float middle = 0;    ///< in the middle of the image
  float x = 0, y = 0;  ///< slopes @units{depth per pixel}

  SWIFTGS_HD float at(vec2 point) const { return middle + (x * point.x + y * point.y); }
  /// The k-th coefficient of the square of `at`.
  SWIFTGS_HD float square(int k) const {
    const float with[] = {middle, 2 * x, 2 * y, x, 2 * y, y}, of[] = {middle, middle, middle, x, x, y};
    return with[k] * of[k];
  }
};

/// Centre of pixel (x, y) of the view's frame, from the middle of its image. Exact. @units{pixels}
SWIFTGS_HD inline vec2 point_of(const View& view, std::size_t x, std::size_t y) {
  return vec2(float(view.left() + int(x)) + 0.5f - 0.5f * view.camera.width,
              float(view.top() + int(y)) + 0.5f - 0.5f * view.camera.height);
}

/// Whether pixels of `view` need depths along their rays for `planes`, a `Request` or a `FrameView`. They are
/// then its first attributes.
template <class Planes>
SWIFTGS_HD bool takes_ray_depth(const View& view, const Planes& planes) {
  return view.camera.depth_along_ray && (planes.depth || planes.squared_depth || planes.first_depth ||
                                         planes.median_depth || planes.occluder);
}
/// Whether they need them for what is asked for.
SWIFTGS_HD inline bool asks_for_ray_depth(const View& view) { return takes_ray_depth(view, view.request); }

/// Whether `view` has an occluder that hides splats by their depths along the ray. These do not ascend in a
/// list, so that a pixel skips a hidden splat, where by the depths of means it ends.
SWIFTGS_HD inline bool hides_along_ray(const View& view) {
  return view.camera.depth_along_ray && view.frame.occluder.data;
}

/// Attributes that a view asks for.
SWIFTGS_HD inline int attribute_count(const View& view) {
  const Request& request = view.request;
  const int squared = view.camera.depth_along_ray ? RayDepth::squares : 1;
  return (asks_for_ray_depth(view) ? RayDepth::terms : 0) + (request.normal ? 3 : 0) +
         (request.squared_depth ? squared : 0) + (request.features ? view.frame.feature_channels : 0);
}
/// Most attributes that one view asks for.
inline int attribute_count(Span<const View> views) {
  int most = 0;
  for (const View& view : views) most = std::max(most, attribute_count(view));
  return most;
}

/// Four attributes of a splat, in one 16-byte load.
struct alignas(16) AttributeRow {
  static constexpr unsigned channels = 4;
  float values[channels] = {};
};

/// Attributes that are rasterized together: @shape{splats, rows}.
struct AttributesView {
  static constexpr unsigned most_rows = 4, most = most_rows * AttributeRow::channels;
  /// Rows that so many attributes take.
  static constexpr unsigned rows_for(int attributes) {
    const int count = attributes < 0 ? 0 : attributes < int(most) ? attributes : int(most);
    return (unsigned(count) + AttributeRow::channels - 1) / AttributeRow::channels;
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

/// One rasterization of a frame.
struct RasterPass {
  int first = 0;        ///< attribute of the frame that is the first here
  unsigned rows = 0;    ///< of attributes
  bool is_base = true;  ///< draws all planes but those of attributes
};

/// The passes of a frame: one for up to `AttributesView::most` attributes, and one for each as many more.
class RasterPasses {
 public:
  explicit RasterPasses(int attributes = 0) : attributes_(attributes) {}

  std::size_t size() const {
    constexpr int most = int(AttributesView::most);
    return attributes_ <= most ? 1 : std::size_t((attributes_ + most - 1) / most);
  }
  RasterPass operator[](std::size_t k) const {
    const int first = int(k * AttributesView::most);
    return {first, AttributesView::rows_for(attributes_ - first), k == 0};
  }

  /// Rows of attributes that a splat takes in memory: where there are several passes, its first row is kept
  /// behind those of a pass.
  unsigned kept_rows() const { return AttributesView::rows_for(attributes_) + (size() > 1 ? 1 : 0); }

 private:
  int attributes_;
};

}  // namespace swiftgs
