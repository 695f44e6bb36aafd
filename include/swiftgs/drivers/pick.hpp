// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Which Gaussians are at pixels of a frame that was drawn, by its splats and tile lists: no second frame.

#include <cmath>
#include <cstddef>
#include <cstdint>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/backend.hpp>
#include <swiftgs/frame/frame_view.hpp>
#include <swiftgs/frame/raster.hpp>
#include <swiftgs/frame/splats.hpp>
#include <swiftgs/frame/tiles.hpp>
#include <swiftgs/frame/views.hpp>
#include <swiftgs/plane/picks.hpp>
#include <swiftgs/raster/exponents.hpp>

namespace swiftgs {

/// The Gaussian of the largest weight at a pixel, and the median one. A weight is alpha times transmittance,
/// as `AxisSharedThreshold<FloatCholesky>` blends with it. Depths are of the Gaussians' means, as
/// `Conventions::depth` has it, whatever `Conventions::depth_at` is.
struct PickedPixel {
  static constexpr std::uint32_t nothing = no_gaussian;

  std::uint32_t gaussian = nothing;  ///< index of the largest weight; of equal ones the nearest
  float weight = 0;
  float depth = 0;
  std::uint32_t median = nothing;  ///< the Gaussian that takes the transmittance below 1/2
  float median_depth = 0;

  bool operator==(const PickedPixel&) const = default;
};

/// Pixels of one view of a frame.
struct PickRectangle {
  int x = 0, y = 0;           ///< its first pixel, from the top left of the view's frame
  int width = 1, height = 1;  ///< 1 to `max_pick_side`
  std::size_t view = 0;       ///< index among the views of the frame
};

/// @units{pixels}
inline constexpr int max_pick_side = 64;

/// Throws `InvalidArgument` unless `rectangle` lies in a frame of this size.
inline void validate(const PickRectangle& rectangle, int width, int height) {
  const auto check = [](const char* name, int begin, int size, int whole) {
    if (size < 1 || size > max_pick_side)
      detail::refuse("pick: the rectangle has ", size, " pixels along ", name, ", expected 1 to ",
                     max_pick_side);
    if (begin < 0 || begin > whole - size)
      detail::refuse("pick: the rectangle has pixels ", begin, " to ", std::int64_t(begin) + size - 1,
                     " along ", name, ", expected pixels within the frame's ", whole);
  };
  check("x", rectangle.x, rectangle.width, width);
  check("y", rectangle.y, rectangle.height, height);
}

/// What to find. All pointers are to memory that the backend reaches; the planes of the view's frame and its
/// occluder are not looked at.
struct PickJob {
  SplatsView splats;
  Span<const SplatColour> colours;
  TileListsView lists;
  View view;
  int x, y, width, height;  ///< pixels of the view's frame
  PickedPixel* to;          ///< first of the rectangle's pixels
  std::size_t pitch;        ///< from a row to the next @units{pixels}

  SWIFTGS_HD TileRange list(int column, int row) const {
    return lists.ranges[view.grid.tile_at(view.left() + column, view.top() + row)];
  }
  /// Centre of a pixel, in the image.
  SWIFTGS_HD vec2 centre(int column, int row) const {
    return vec2(float(view.left() + column) + 0.5f, float(view.top() + row) + 0.5f);
  }
  /// Centre of the first pixel of the raster block that holds the pixel.
  SWIFTGS_HD vec2 first_centre(int column, int row) const {
    return centre(column - column % raster_block_side, row - row % raster_block_side);
  }
};

/// Alpha of a splat at a pixel centre; 0 where the pixel skips it.
SWIFTGS_HD inline float alpha_at(const SplatShape& shape, vec2 centre, const BlendRules& rules) {
  const FloatCholesky terms(shape, centre);
  const float s = FloatCholesky::exponent(terms.x_term(centre.x), terms.y_term(centre.y));
  if (!(s >= 0 && s <= shape.cutoff)) return 0;
  const float alpha = shape.opacity * std::exp2(-s);
  return alpha < rules.alpha_max ? alpha : rules.alpha_max;
}

/// Picks at one pixel, whose splats are offered front to back.
class PixelPicker {
 public:
  SWIFTGS_HD explicit PixelPicker(float stop_below) : stop_below_(stop_below) {}

  /// Offers the next splat, which the pixel shows with `alpha` > 0. Returns false once no later splat changes
  /// the result.
  SWIFTGS_HD bool offer(float alpha, float depth, std::uint32_t gaussian) {
    const float before = transmittance_, next = dimmed(before, alpha), weight = alpha * before;
    if (next < stop_below_) return false;
    if (weight > picked_.weight) picked_.gaussian = gaussian, picked_.weight = weight, picked_.depth = depth;
    if (before >= median_below && next < median_below)
      picked_.median = gaussian, picked_.median_depth = depth;
    transmittance_ = next;
    return next >= median_below || next > picked_.weight;
  }

  SWIFTGS_HD const PickedPixel& picked() const { return picked_; }

 private:
  float stop_below_, transmittance_ = 1;
  PickedPixel picked_;
};

/// Picks at the i-th pixel of the rectangle, counted by rows, on a host.
struct PickPixel {
  PickJob job;

  void operator()(std::size_t i) const {
    const int x = job.x + int(i) % job.width, y = job.y + int(i) / job.width;
    const vec2 centre = job.centre(x, y);
    const float first_x = job.first_centre(x, y).x;
    PixelPicker picker(job.view.rules.stop_below);
    const TileRange range = job.list(x, y);
    for (std::uint32_t at = range.begin; at < range.end; ++at) {
      const std::uint32_t id = job.lists.ids[at];
      const SplatShape& shape = job.splats.shapes[id];
      if (is_colourless(job.colours[id]) || !row_touched(shape, first_x, centre.y)) continue;
      const float alpha = alpha_at(shape, centre, job.view.rules);
      if (alpha > 0 && !picker.offer(alpha, job.colours[id].depth, job.splats.gaussians[id])) break;
    }
    job.to[std::size_t(y - job.y) * job.pitch + std::size_t(x - job.x)] = picker.picked();
  }
};

/// Picks at the pixels of `job`, on hosts. A device overloads this.
template <FunctorBackend B>
requires(bool(B::reaches_host_memory)) void pick_pixels(B& b, const PickJob& job) {
  b.for_each(std::size_t(job.width) * std::size_t(job.height), PickPixel{job});
}

}  // namespace swiftgs
