// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How a scene is placed: moved and scaled, clipped and tinted.

#include <cmath>

#include <glm/matrix.hpp>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/math.hpp>

namespace swiftgs {

/// A movement that keeps shapes: p becomes scale * rotation p + translation.
struct Similarity {
  dmat3 rotation{1.0};  ///< orthonormal, of determinant 1; GLM stores it by columns: rotation[column][row]
  double scale = 1;     ///< above 0
  dvec3 translation{0.0};

  dvec3 operator()(const dvec3& p) const { return scale * (rotation * p) + translation; }

  /// Says what was expected, or is null if it is valid.
  SWIFTGS_HD const char* unmet() const {
    if (!(detail::is_finite(scale) && scale > 0)) return "a finite scale above 0";
    if (!detail::is_finite(translation)) return "a finite translation";
    const dvec3 &x = rotation[0], &y = rotation[1], &z = rotation[2];
    const auto near = [](double value, double wanted) { return std::fabs(value - wanted) < 1e-6; };
    if (!(near(dot(x, x), 1) && near(dot(y, y), 1) && near(dot(z, z), 1) && near(dot(x, y), 0) &&
          near(dot(x, z), 0) && near(dot(y, z), 0)))
      return "a rotation with orthonormal columns";
    return dot(cross(x, y), z) > 0 ? nullptr : "a rotation, not a mirror";
  }

  SWIFTGS_HD bool is_identity() const {
    bool same = scale == 1;
    for (int i = 0; i < 3; ++i) {
      same = same && translation[i] == 0;
      for (int j = 0; j < 3; ++j) same = same && rotation[i][j] == (i == j ? 1 : 0);
    }
    return same;
  }
};

/// Throws `InvalidArgument` that names the first invalid member of what `what` says.
inline void validate(const Similarity& by, const char* what = "transform") {
  if (const char* const expected = by.unmet()) detail::refuse(what, ": expected ", expected);
}

/// The movement that undoes `by`. Throws as `validate` does.
inline Similarity inverse(const Similarity& by) {
  validate(by);
  Similarity back;
  back.rotation = glm::transpose(by.rotation), back.scale = 1 / by.scale;
  back.translation = -back.scale * (back.rotation * by.translation);
  return back;
}

/// Clips a scene: a Gaussian shows if its mean lies in all half-spaces and in the sphere. Both are in the
/// scene's own space, and move with the scene. By default all Gaussians show.
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

/// A colour that is mixed into the colours of a scene's Gaussians, such as a highlight. By default nothing is
/// mixed in.
struct Tint {
  vec3 colour{1.0f};  ///< RGB, in the scene's own values, 0 or more
  float amount = 0;   ///< 0 to 1: 0 leaves the Gaussians' colours, 1 shows `colour` alone

  /// Says what was expected, or is null if it is valid.
  SWIFTGS_HD const char* unmet() const {
    if (!(amount >= 0 && amount <= 1)) return "a tint with an amount of 0 to 1";
    const bool shown = colour.x >= 0 && colour.y >= 0 && colour.z >= 0;
    return shown && detail::is_finite(colour) ? nullptr : "a tint with a finite colour of 0 or more";
  }
  SWIFTGS_HD bool is_none() const { return amount == 0; }

  /// (1 - amount) `from` + amount `colour`, where `from` is finite and 0 or more, and so is the result. All
  /// backends answer alike.
  SWIFTGS_HD vec3 mixed_into(vec3 from) const {
    const float most = 3.4028234663852886e38f;  // rounding may pass it
    vec3 mixed;
    for (int c = 0; c < 3; ++c) {
      const float sum = std::fma(amount, colour[c], (1 - amount) * from[c]);
      mixed[c] = sum < most ? sum : most;
    }
    return mixed;
  }
};

}  // namespace swiftgs

namespace swiftgs::detail {

/// Says what was expected, or is null if a frame can show a scene like this.
SWIFTGS_HD inline const char* unmet_of_placing(const Similarity& world_from_scene, float opacity,
                                               const Clip& clip, const Tint& tint) {
  if (const char* const expected = world_from_scene.unmet()) return expected;
  if (!(opacity >= 0 && opacity <= 1)) return "an opacity of 0 to 1";
  if (const char* const expected = clip.unmet()) return expected;
  return tint.unmet();
}

/// Throws `InvalidArgument` unless a frame can show a scene like this.
inline void validate_placing(const Similarity& world_from_scene, float opacity, const Clip& clip,
                             const Tint& tint) {
  if (const char* const expected = unmet_of_placing(world_from_scene, opacity, clip, tint))
    refuse("placed scene: expected ", expected);
}

}  // namespace swiftgs::detail
