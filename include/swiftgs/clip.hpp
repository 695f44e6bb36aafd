// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include <swiftgs/finite.hpp>
#include <swiftgs/math.hpp>

namespace swiftgs {

/// Which Gaussians of a scene show: those whose mean lies in all half-spaces and in the sphere. It is in the
/// scene's own space, and moves with it. By default all show.
struct Clip {
  static constexpr int max_half_spaces = 6;

  /// Points p with (x, y, z) . p + w >= 0; the first `half_space_count` count.
  vec4 half_spaces[max_half_spaces] = {};
  int half_space_count = 0;
  vec3 centre{0.0f};        ///< of the sphere
  float radius = INFINITY;  ///< infinite: no sphere

  static Clip box(vec3 low, vec3 high) {
    Clip clip;
    clip.half_space_count = 6;
    for (int axis = 0; axis < 3; ++axis) {
      clip.half_spaces[2 * axis][axis] = 1, clip.half_spaces[2 * axis].w = -low[axis];
      clip.half_spaces[2 * axis + 1][axis] = -1, clip.half_spaces[2 * axis + 1].w = high[axis];
    }
    return clip;
  }
  static Clip sphere(vec3 centre, float radius) {
    Clip clip;
    clip.centre = centre, clip.radius = radius;
    return clip;
  }

  /// Says what was expected, or is null if it is valid.
  SWIFTGS_HD const char* unmet() const {
    static_assert(max_half_spaces == 6);
    if (half_space_count < 0 || half_space_count > max_half_spaces) return "a clip of 0 to 6 half-spaces";
    for (int i = 0; i < half_space_count; ++i)
      for (int k = 0; k < 4; ++k)
        if (!detail::is_finite(half_spaces[i][k])) return "a clip with half-spaces of finite numbers";
    if (!detail::is_finite(centre)) return "a clip with a finite centre";
    return radius >= 0 ? nullptr : "a clip with a radius of 0 or more";
  }
  SWIFTGS_HD bool shows_all() const { return half_space_count == 0 && radius == INFINITY; }

  /// Whether a Gaussian with this mean shows. All backends answer alike.
  SWIFTGS_HD bool shows(vec3 mean) const {
    bool inside = true;
    for (int i = 0; i < half_space_count; ++i) {
      const vec4& h = half_spaces[i];
      inside = inside && std::fma(h.x, mean.x, std::fma(h.y, mean.y, std::fma(h.z, mean.z, h.w))) >= 0;
    }
    if (radius == INFINITY) return inside;
    const vec3 from(mean.x - centre.x, mean.y - centre.y, mean.z - centre.z);
    return inside && dot(from, from) <= radius * radius;
  }
};

}  // namespace swiftgs
