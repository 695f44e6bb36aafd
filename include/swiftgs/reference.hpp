// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The float64 renderer that judges every other renderer. It follows `Conventions`, approximates nothing
/// beyond them, and shares no arithmetic with the renderers that it judges but the limits of lenses.

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <vector>

#include <swiftgs/camera.hpp>
#include <swiftgs/conventions.hpp>
#include <swiftgs/math.hpp>
#include <swiftgs/parallel.hpp>
#include <swiftgs/reference/blending.hpp>
#include <swiftgs/reference/projection.hpp>
#include <swiftgs/scene.hpp>
#include <swiftgs/span.hpp>

namespace swiftgs {

/// An image in double precision, rows from top to bottom, with counts.
struct ReferenceFrame {
  int width = 0, height = 0;
  std::vector<double> colour;  ///< @shape{height, width, 3} RGB, the scene's own values, not clamped above
  std::vector<double> alpha;   ///< @shape{height, width} 1 - transmittance
  std::vector<double> depth;   ///< @shape{height, width} mean depth, weighted by contribution; 0
                               ///< where nothing contributes
  std::uint64_t visible = 0;   ///< Gaussians that contribute to at least one pixel
  std::uint64_t contributing_pairs = 0;  ///< contributions of a Gaussian to a pixel
  std::uint64_t pixels_stopped = 0;      ///< pixels that the stop rule or an occluder ended
};

/// Whether all values are finite.
inline bool is_finite(const ReferenceFrame& frame) {
  for (const std::vector<double>* values : {&frame.colour, &frame.alpha, &frame.depth})
    for (const double value : *values)
      if (!std::isfinite(value)) return false;
  return true;
}

namespace reference {

/// Number of rows that are blended together: enough to fetch each splat rarely, and few enough to keep their
/// pixels in a core's cache.
inline constexpr int strip_rows = 16;

/// The splats of a frame, in chunks of consecutive Gaussians, in the order of their numbers.
using SplatChunks = std::vector<std::vector<Splat>>;

/// The views of all placed scenes. Gaussians are numbered over the frame.
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

/// The splats that reach each strip of rows, front to back: ordered by depth rounded to float, as the
/// convention demands, and by number where depths are equal.
inline std::vector<std::vector<const Splat*>> sort_into_strips(const SplatChunks& chunks, int height) {
  struct Entry {
    float depth;
    const Splat* splat;
  };
  std::vector<Entry> order;
  for (const std::vector<Splat>& chunk : chunks)
    for (const Splat& splat : chunk) order.push_back({float(splat.depth), &splat});
  std::stable_sort(order.begin(), order.end(),
                   [](const Entry& a, const Entry& b) { return a.depth < b.depth; });

  std::vector<std::vector<const Splat*>> strips(std::size_t(height + strip_rows - 1) / strip_rows);
  for (const Entry& entry : order)
    for (int strip = entry.splat->y_begin / strip_rows; strip * strip_rows < entry.splat->y_end; ++strip)
      strips[std::size_t(strip)].push_back(entry.splat);
  return strips;
}

/// Writes image row `y`.
inline void write_row(ReferenceFrame& frame, int y, const Pixel* pixels, dvec3 background) {
  for (int x = 0; x < frame.width; ++x) {
    const Pixel& pixel = pixels[x];
    const std::size_t i = std::size_t(y) * std::size_t(frame.width) + std::size_t(x);
    for (int c = 0; c < 3; ++c)
      frame.colour[3 * i + std::size_t(c)] = pixel.colour[c] + pixel.transmittance * background[c];
    frame.alpha[i] = 1 - pixel.transmittance;
    frame.depth[i] = pixel.weight > 0 ? pixel.depth / pixel.weight : 0;
  }
}

/// Counts shared by the threads.
struct Counts {
  explicit Counts(std::size_t gaussians) : seen(gaussians) {}

  std::vector<std::atomic<bool>> seen;  ///< whether a Gaussian has contributed
  std::atomic<std::uint64_t> pairs{0}, stopped{0};
};

/// Blends `splats`, front to back, into the image rows [first, last) of `frame`.
inline void render_rows(ReferenceFrame& frame, Counts& counts, const std::vector<const Splat*>& splats,
                        int first, int last, const Conventions& conventions, dvec3 background,
                        Span<const float> occluder) {
  const std::size_t width = std::size_t(frame.width);
  std::vector<Pixel> pixels(width * std::size_t(last - first));
  for (std::size_t i = 0; occluder.size > 0 && i < pixels.size(); ++i)
    pixels[i].occluder = occluder[width * std::size_t(first) + i];
  const auto row = [&](int y) { return pixels.data() + width * std::size_t(y - first); };
  std::uint64_t pairs = 0;
  for (const Splat* splat : splats) {
    const std::uint64_t before = pairs;
    for (int y = std::max(first, splat->y_begin); y < std::min(last, splat->y_end); ++y)
      pairs += blend_row(row(y), y, *splat, conventions);
    if (pairs > before) counts.seen[splat->index].store(true, std::memory_order_relaxed);
  }
  for (int y = first; y < last; ++y) write_row(frame, y, row(y), background);
  counts.pairs += pairs;
  counts.stopped += std::uint64_t(
      std::count_if(pixels.begin(), pixels.end(), [](const Pixel& pixel) { return pixel.stopped; }));
}

/// Throws `std::invalid_argument` for invalid arguments of `render_reference`.
inline void check_reference_arguments(Span<const ReferenceScene> scenes, const Camera& camera,
                                      dvec3 background, Span<const float> occluder) {
  for (const ReferenceScene& placed : scenes) validate(placed);
  validate(camera);
  if (!std::isfinite(background.x) || !std::isfinite(background.y) || !std::isfinite(background.z))
    throw std::invalid_argument("render_reference: expected a finite background");
  const std::size_t pixels = std::size_t(camera.width) * std::size_t(camera.height);
  if (occluder.size != 0 && occluder.size != pixels)
    throw std::invalid_argument("render_reference: expected an occluder of the camera's size");
}

/// Gives `frame` the size of the camera's image.
inline void prepare(ReferenceFrame& frame, const Camera& camera) {
  frame.width = camera.width, frame.height = camera.height;
  const std::size_t pixels = std::size_t(camera.width) * std::size_t(camera.height);
  frame.colour.resize(3 * pixels), frame.alpha.resize(pixels), frame.depth.resize(pixels);
}

}  // namespace reference

/// Renders placed scenes in double precision on `threads` threads (0: one a processor); the result does not
/// depend on their number. All stored SH bands are evaluated. Gaussians that are not finite are left out.
/// `occluder`: @shape{height, width} as `FrameView::occluder`; empty for none.
/// Throws `std::invalid_argument` when a scene, `camera` or the size of `occluder` is not valid, `background`
/// is not finite or `threads` is negative.
inline ReferenceFrame render_reference(Span<const ReferenceScene> scenes, const Camera& camera,
                                       const Conventions& conventions, dvec3 background = dvec3(0),
                                       int threads = 0, Span<const float> occluder = {}) {
  using namespace reference;
  check_reference_arguments(scenes, camera, background, occluder);
  threads = thread_count(threads);
  const SplatChunks chunks = project_all(views_of(scenes, camera, conventions), threads);
  const std::vector<std::vector<const Splat*>> strips = sort_into_strips(chunks, camera.height);

  ReferenceFrame frame;
  prepare(frame, camera);
  Counts counts(gaussians_of(scenes));
  for_each_index(strips.size(), threads, [&](std::size_t strip) {
    const int first = int(strip) * strip_rows, last = std::min(camera.height, first + strip_rows);
    render_rows(frame, counts, strips[strip], first, last, conventions, background, occluder);
  });
  frame.visible = std::uint64_t(std::count(counts.seen.begin(), counts.seen.end(), true));
  frame.contributing_pairs = counts.pairs;
  frame.pixels_stopped = counts.stopped;
  return frame;
}
/// The same of a scene alone, where it stands by itself.
inline ReferenceFrame render_reference(const Scene& scene, const Camera& camera,
                                       const Conventions& conventions, dvec3 background = dvec3(0),
                                       int threads = 0, Span<const float> occluder = {}) {
  const ReferenceScene alone{scene};
  return render_reference({&alone, 1}, camera, conventions, background, threads, occluder);
}

}  // namespace swiftgs
