// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The float64 renderer that judges every other renderer. It follows `Conventions`, approximates nothing
/// beyond them, and shares no arithmetic with the renderers that it judges but the limits of lenses.

#include <cmath>
#include <cstdint>
#include <vector>

#include <swiftgs/api.hpp>
#include <swiftgs/camera.hpp>
#include <swiftgs/conventions.hpp>
#include <swiftgs/math.hpp>
#include <swiftgs/reference/placed.hpp>
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

/// Renders placed scenes in double precision on `threads` threads (0: one a processor); the result does not
/// depend on their number. All stored SH bands are evaluated. Gaussians that are not finite are left out.
/// `occluder`: @shape{height, width} as `FrameView::occluder`; empty for none.
/// Throws `InvalidArgument` when a scene, `camera` or the size of `occluder` is not valid, `background`
/// is not finite or `threads` is negative.
SWIFTGS_API ReferenceFrame render_reference(Span<const ReferenceScene> scenes, const Camera& camera,
                                            const Conventions& conventions, dvec3 background = dvec3(0),
                                            int threads = 0, Span<const float> occluder = {});
/// The same of a scene alone, where it stands by itself.
inline ReferenceFrame render_reference(const Scene& scene, const Camera& camera,
                                       const Conventions& conventions, dvec3 background = dvec3(0),
                                       int threads = 0, Span<const float> occluder = {}) {
  const ReferenceScene alone{scene};
  return render_reference({&alone, 1}, camera, conventions, background, threads, occluder);
}

}  // namespace swiftgs
