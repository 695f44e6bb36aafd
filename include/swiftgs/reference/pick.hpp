// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <swiftgs/pick.hpp>
#include <swiftgs/reference.hpp>

namespace swiftgs {

/// What a pixel shows most, in double precision. An index is `PickedPixel::nothing` where there is none.
struct ReferencePick {
  std::uint32_t gaussian = PickedPixel::nothing, median = PickedPixel::nothing;
  double weight = 0, depth = 0, median_depth = 0;
  double next_weight = 0;  ///< the largest weight of another Gaussian
  double from_half = 0.5;  ///< distance of 1/2 from the nearest transmittance, that before all splats included
};

namespace reference {
/// Offers all splats, which are in order, to one pixel.
inline ReferencePick pick(const std::vector<const Splat*>& splats, int x, int y,
                          const Conventions& conventions) {
  ReferencePick out;
  std::vector<Pixel> row(std::size_t(x) + 1);
  Pixel& pixel = row.back();
  for (const Splat* splat : splats) {
    if (pixel.stopped) break;
    if (x < splat->x_begin || x >= splat->x_end || y < splat->y_begin || y >= splat->y_end) continue;
    Splat here = *splat;
    here.x_begin = x, here.x_end = x + 1;
    const double before = pixel.transmittance, weights = pixel.weight;
    if (blend_row(row.data(), y, here, conventions) == 0) continue;
    const double weight = pixel.weight - weights;
    const auto index = std::uint32_t(splat->index);
    if (weight > out.weight) {
      out.next_weight = out.weight;
      out.gaussian = index, out.weight = weight, out.depth = splat->depth;
    } else {
      out.next_weight = std::max(out.next_weight, weight);
    }
    if (before >= 0.5 && pixel.transmittance < 0.5) out.median = index, out.median_depth = splat->depth;
    out.from_half = std::min(out.from_half, std::abs(pixel.transmittance - 0.5));
  }
  return out;
}
}  // namespace reference

/// Picks at every pixel of an image, by rows. Throws as `render_reference`.
inline std::vector<ReferencePick> pick_reference(const Scene& scene, const Camera& camera,
                                                 const Conventions& conventions) {
  using namespace reference;
  check_reference_arguments(scene, camera, dvec3(0), {});
  const SplatChunks chunks = project_all(scene, reference::View(camera, conventions), 1);
  const std::vector<std::vector<const Splat*>> strips = sort_into_strips(chunks, camera.height);
  std::vector<ReferencePick> picks;
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x)
      picks.push_back(pick(strips[std::size_t(y / strip_rows)], x, y, conventions));
  return picks;
}

}  // namespace swiftgs
