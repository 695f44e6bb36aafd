// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <swiftgs/reference.hpp>
#include <swiftgs/tools/parallel.hpp>

#include "rendering.hpp"

namespace swiftgs {
namespace reference {
namespace {

/// Writes image row `y`, blended in `colours` over `below`.
void write_row(ReferenceFrame& frame, int y, const Pixel* pixels, ColourSpace colours, dvec3 below) {
  for (int x = 0; x < frame.width; ++x) {
    const Pixel& pixel = pixels[x];
    const std::size_t i = std::size_t(y) * std::size_t(frame.width) + std::size_t(x);
    for (int c = 0; c < 3; ++c)
      frame.colour[3 * i + std::size_t(c)] = shown(pixel.colour[c] + pixel.transmittance * below[c], colours);
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
void render_rows(ReferenceFrame& frame, Counts& counts, const std::vector<const Splat*>& splats, int first,
                 int last, const Conventions& conventions, dvec3 background, Span<const float> occluder) {
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
  const dvec3 below = blended(background, *conventions.colours);
  for (int y = first; y < last; ++y) write_row(frame, y, row(y), *conventions.colours, below);
  counts.pairs += pairs;
  counts.stopped += std::uint64_t(
      std::count_if(pixels.begin(), pixels.end(), [](const Pixel& pixel) { return pixel.stopped; }));
}

}  // namespace
}  // namespace reference

ReferenceFrame render_reference(Span<const ReferenceScene> scenes, const Camera& camera,
                                const Conventions& given, dvec3 background, int threads,
                                Span<const float> occluder) {
  using namespace reference;
  check_reference_arguments(scenes, camera, background, occluder);
  const Conventions conventions = of_frame(given, scenes, occluder.size != 0);
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

}  // namespace swiftgs
