// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What frames and planes have in common: views of placed scenes, their splats in order, and blending.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <swiftgs/camera.hpp>
#include <swiftgs/conventions.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/reference.hpp>
#include <swiftgs/tools/parallel.hpp>

#include "projection.hpp"

namespace swiftgs::reference {

/// Number of rows that are blended together: enough to fetch each splat rarely, and few enough to keep their
/// pixels in a core's cache.
inline constexpr int strip_rows = 16;

/// The splats of a frame, in chunks of consecutive Gaussians, in the order of their numbers.
using SplatChunks = std::vector<std::vector<Splat>>;

/// `conventions` with the order and the colours that they leave to the scenes of a frame.
inline Conventions of_frame(Conventions conventions, Span<const ReferenceScene> scenes, bool has_occluder) {
  const bool leaves_order = !conventions.order, leaves_colours = !conventions.colours;
  for (const ReferenceScene& placed : scenes) {
    const RenderingModel& model = placed.scene.model;
    if (placed.scene.size() == 0) continue;
    if (leaves_order && !has_occluder && model.order == SplatOrder::distance) conventions.order = model.order;
    if (leaves_colours && conventions.colours.value_or(model.colours) != model.colours)
      throw InvalidArgument("render_reference: expected scenes of one kind of colours");
    if (leaves_colours) conventions.colours = model.colours;
  }
  if (has_occluder && conventions.order == SplatOrder::distance)
    throw InvalidArgument("render_reference: expected an order by depth beside an occluder");
  if (!conventions.order) conventions.order = SplatOrder::depth;
  if (!conventions.colours) conventions.colours = ColourSpace::srgb;
  return conventions;
}

/// The sRGB curve of IEC 61966-2-1, continued above 1, and below 0 as an odd function.
inline double encoded(double light) {
  const double x = std::abs(light);
  return std::copysign(x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055, light);
}
inline double decoded(double value) {
  const double x = std::abs(value);
  return std::copysign(x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4), value);
}

/// A background as splats are blended with it in `colours`, and a blended value as an image shows it.
inline dvec3 blended(dvec3 background, ColourSpace colours) {
  if (colours == ColourSpace::srgb) return background;
  return dvec3(decoded(background.x), decoded(background.y), decoded(background.z));
}
inline double shown(double blended, ColourSpace colours) {
  return colours == ColourSpace::srgb ? blended : encoded(blended);
}

/// The views of all placed scenes, by conventions as of `of_frame`. Gaussians are numbered over the frame.
inline std::vector<View> views_of(Span<const ReferenceScene> scenes, const Camera& camera,
                                  const Conventions& conventions) {
  std::vector<View> views;
  std::size_t first = 0;
  for (const ReferenceScene& placed : scenes) {
    views.emplace_back(camera, conventions, placed, first);
    first += placed.scene.size();
  }
  return views;
}
inline std::size_t gaussians_of(Span<const ReferenceScene> scenes) {
  std::size_t sum = 0;
  for (const ReferenceScene& placed : scenes) sum += placed.scene.size();
  return sum;
}

inline SplatChunks project_all(const std::vector<View>& views, int threads) {
  struct Range {
    const View* view;
    std::size_t begin, end;
  };
  constexpr std::size_t chunk = 1 << 14;
  std::vector<Range> ranges;
  for (const View& view : views) {
    const std::size_t size = view.placed.scene.size();
    for (std::size_t begin = 0; begin < size; begin += chunk)
      ranges.push_back({&view, begin, std::min(size, begin + chunk)});
  }
  SplatChunks chunks(ranges.size());
  for_each_index(chunks.size(), threads, [&](std::size_t c) {
    const auto [view, begin, end] = ranges[c];
    for (std::size_t i = begin; i < end; ++i)
      for (const Columns part : view->parts)
        if (const std::optional<Splat> splat = project(i, *view, part)) chunks[c].push_back(*splat);
  });
  return chunks;
}

/// The splats that reach each strip of rows, front to back: by depth or distance rounded to float, as the
/// convention demands, and by number where these are equal.
inline std::vector<std::vector<const Splat*>> sort_into_strips(const SplatChunks& chunks, int height) {
  struct Entry {
    float order;
    const Splat* splat;
  };
  std::vector<Entry> order;
  for (const std::vector<Splat>& chunk : chunks)
    for (const Splat& splat : chunk) order.push_back({float(splat.order), &splat});
  std::stable_sort(order.begin(), order.end(),
                   [](const Entry& a, const Entry& b) { return a.order < b.order; });

  std::vector<std::vector<const Splat*>> strips(std::size_t(height + strip_rows - 1) / strip_rows);
  for (const Entry& entry : order)
    for (int strip = entry.splat->y_begin / strip_rows; strip * strip_rows < entry.splat->y_end; ++strip)
      strips[std::size_t(strip)].push_back(entry.splat);
  return strips;
}

/// Throws `InvalidArgument` for invalid arguments of `render_reference`.
inline void check_reference_arguments(Span<const ReferenceScene> scenes, const Camera& camera,
                                      dvec3 background, Span<const float> occluder) {
  for (const ReferenceScene& placed : scenes) validate(placed);
  validate(camera);
  if (!std::isfinite(background.x) || !std::isfinite(background.y) || !std::isfinite(background.z))
    throw InvalidArgument("render_reference: expected a finite background");
  const std::size_t pixels = std::size_t(camera.width) * std::size_t(camera.height);
  if (occluder.size != 0 && occluder.size != pixels)
    throw InvalidArgument("render_reference: expected an occluder of the camera's size");
}

/// Gives `frame` the size of the camera's image.
inline void prepare(ReferenceFrame& frame, const Camera& camera) {
  frame.width = camera.width, frame.height = camera.height;
  const std::size_t pixels = std::size_t(camera.width) * std::size_t(camera.height);
  frame.colour.resize(3 * pixels), frame.alpha.resize(pixels), frame.depth.resize(pixels);
}

/// What a pixel has collected so far.
struct Pixel {
  Eigen::Vector3d colour = Eigen::Vector3d::Zero();  ///< sum of weight * colour
  double transmittance = 1;
  double weight = 0;  ///< sum of weights
  double depth = 0;   ///< sum of weight * depth
  bool stopped = false;
  float occluder = std::numeric_limits<float>::infinity();  ///< a splat of this depth or more is hidden
};

/// Offers `splat`, whose exponent and depth at this pixel are `sigma` and `depth`, to `pixel`; true when it
/// contributed.
inline bool blend(Pixel& pixel, const Splat& splat, double sigma, double depth, const Conventions& k) {
  if (k.footprint == Conventions::Footprint::three_sigma_ellipse && 2 * sigma > three_sigmas_squared)
    return false;
  const double alpha = std::min(double(k.alpha_max), splat.opacity * std::exp(-sigma));
  if (!(alpha >= double(k.alpha_min))) return false;
  const double next = pixel.transmittance * (1 - alpha), stop = k.stop;
  // Depths are compared rounded to float, as they are sorted. A splat hidden by the depth of its mean hides
  // all behind it too, so the pixel stops; depths along the ray may decrease again.
  const bool hidden = float(depth) >= pixel.occluder, along_ray = k.depth_at == Conventions::DepthAt::ray;
  if (hidden && along_ray) return false;
  if (hidden || (k.stop_at_equal ? next <= stop : next < stop)) {
    pixel.stopped = true;
    return false;
  }
  const double weight = alpha * pixel.transmittance;
  pixel.colour += weight * splat.colour;
  pixel.weight += weight;
  pixel.depth += weight * depth;
  pixel.transmittance = next;
  return true;
}

/// Offers `splat` to the pixels of image row `y`, of which `pixels` is the first; returns to how many it
/// contributed.
inline std::uint64_t blend_row(Pixel* pixels, int y, const Splat& splat, const Conventions& k) {
  const double dy = y + 0.5 - splat.y;
  const double y_term = splat.y_weight * dy * dy;
  const double left = splat.cutoff - y_term;
  if (!(left >= 0)) return 0;

  // Solve 2 sigma <= cutoff for x; the slack is far above what rounding can move the two roots.
  const double offset = splat.shear * dy, half = std::sqrt(left / splat.x_weight);
  const double slack = 1 + 1e-9 * (std::abs(offset) + half);
  const double middle = splat.x + offset - 0.5;
  const auto column = [&](double x) {
    return int(std::clamp(x, double(splat.x_begin), double(splat.x_end)));
  };
  const int begin = column(std::ceil(middle - half - slack));
  const int end = column(std::floor(middle + half + slack) + 1);

  std::uint64_t contributions = 0;
  for (int x = begin; x < end; ++x) {
    if (pixels[x].stopped) continue;
    const double dx = x + 0.5 - splat.x;
    const double along = dx - offset;
    const double twice_sigma = splat.x_weight * along * along + y_term;
    if (twice_sigma > splat.cutoff) continue;
    contributions += blend(pixels[x], splat, 0.5 * twice_sigma, splat.depth_at(x, y), k);
  }
  return contributions;
}

}  // namespace swiftgs::reference
