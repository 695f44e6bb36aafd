// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The float64 renderer that judges every other renderer. It follows `Conventions`, approximates nothing
/// beyond them, and shares no arithmetic with the renderers that it judges but the limits of lenses.
/// For all planes it also tells how near each pixel's decisions are to others.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <swiftgs/camera.hpp>
#include <swiftgs/conventions.hpp>
#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/frame_view.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/placing.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/scene.hpp>

namespace swiftgs {

/// A placed scene of the reference: as `PlacedScene`, of a scene on the host, which must outlive it.
struct ReferenceScene {
  const Scene& scene;
  Similarity world_from_scene{};
  float opacity = 1;
  Clip clip{};
  Tint tint{};
};

/// Throws `InvalidArgument` as `validate` of a `PlacedScene`.
inline void validate(const ReferenceScene& placed) {
  validate(placed.scene);
  detail::validate_placing(placed.world_from_scene, placed.opacity, placed.clip, placed.tint);
}

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

/// The planes of `Frame`, before a black background, and margins of each pixel @shape{height, width}. In a
/// pixel with a small margin a renderer may decide otherwise.
struct ReferencePlanes : PerPlane<std::vector<double>, std::vector<std::uint32_t>> {
  int width = 0, height = 0, feature_channels = 0;

  std::vector<double> weight, next_weight;  ///< of the Gaussian of `id`, and the largest of the others
  std::vector<double> depth_of_id;          ///< 0 where there is none
  /// How near a transmittance behind some splat comes to the limit that the first splat passes, and to that
  /// of the median splat.
  std::vector<double> first_margin, median_margin;
  std::vector<double> undecided_normals;  ///< weight of splats that rounding may turn to the other side
  /// Least part of itself that an alpha is off `Conventions::alpha_min`, or a transmittance off
  /// `Conventions::stop`.
  std::vector<double> threshold_margin;
  /// Least part of itself that the depth of a splat which could show is off the occluder.
  std::vector<double> occluder_margin;

  std::size_t pixels() const { return std::size_t(width) * std::size_t(height); }
};

/// Renders all planes of placed scenes, with the features that all have, on `threads` threads, as
/// `render_reference` renders colour, alpha and depth. Throws as it does.
SWIFTGS_API ReferencePlanes render_reference_planes(Span<const ReferenceScene> scenes, const Camera& camera,
                                                    const Conventions& conventions, int threads = 0,
                                                    Span<const float> occluder = {});
/// The same of a scene alone, where it stands by itself.
inline ReferencePlanes render_reference_planes(const Scene& scene, const Camera& camera,
                                               const Conventions& conventions, int threads = 0,
                                               Span<const float> occluder = {}) {
  const ReferenceScene alone{scene};
  return render_reference_planes({&alone, 1}, camera, conventions, threads, occluder);
}

}  // namespace swiftgs
