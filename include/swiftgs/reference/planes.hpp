// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// All planes of a frame in double precision, and how near each pixel's decisions are to others.

#include <cstddef>
#include <cstdint>
#include <vector>

#include <swiftgs/api.hpp>
#include <swiftgs/frame.hpp>
#include <swiftgs/reference.hpp>

namespace swiftgs {

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
