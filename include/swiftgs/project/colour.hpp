// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>

#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/placing.hpp>
#include <swiftgs/frame/scene_view.hpp>
#include <swiftgs/frame/splats.hpp>
#include <swiftgs/frame/view_constants.hpp>
#include <swiftgs/project/sh.hpp>

namespace swiftgs {

/// Unit direction from the camera towards `mean`. The largest component is scaled to 1 first, so that no
/// square leaves the range of float.
template <class Real = ProjectingReal>
SWIFTGS_HD vec3 view_direction(const ViewConstants& view, vec3 mean) {
  const ProjectingConstants<Real> v(view);
  vec3 d(float(mean.x - v.centre(0)), float(mean.y - v.centre(1)), float(mean.z - v.centre(2)));
  const float largest = std::fmax(std::fmax(std::fabs(d.x), std::fabs(d.y)), std::fabs(d.z));
  for (int k = 0; k < 3; ++k) d[k] /= largest;
  return d * (1 / std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z));
}

/// Colour of Gaussian `i` in this view, before it is cut below at 0.
SWIFTGS_HD inline vec3 project_colour(const ViewConstants& v, const SceneView& scene, std::size_t i) {
  return sh_colour(scene, i, view_direction(v, scene.means[i]));
}

/// The colour of a splat that a usual sum of floats would lose: colourless only if the colour is not finite.
SWIFTGS_HD inline SplatColour large_splat_colour(const ViewConstants& camera, const SceneView& scene,
                                                 std::size_t i, float depth) {
  const vec3 direction = view_direction(camera, scene.means[i]);
  return splat_colour(large_sh_colour(scene.sh_degree, sh0_of(scene, i), scene.sh_rest[i], direction), depth);
}

/// The colour of a splat under a tint. A colourless splat stays so.
SWIFTGS_HD inline SplatColour tinted(const SplatColour& colour, const Tint& tint) {
  return tint.is_none() ? colour : SplatColour{tint.mixed_into(colour.rgb), colour.depth};
}

}  // namespace swiftgs
