// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include <swiftgs/camera.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/finite.hpp>
#include <swiftgs/math.hpp>

namespace swiftgs {

/// A camera and the point that it turns around.
struct OrbitView {
  Camera camera;
  dvec3 target{0.0};   ///< in the world
  dvec3 up{0, -1, 0};  ///< of any length; y points down in the world of most captures
};

namespace detail {
/// `v` turned about the unit vector `axis`.
inline dvec3 turned(const dvec3& v, const dvec3& axis, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return c * v + s * cross(axis, v) + (1 - c) * dot(axis, v) * axis;
}
}  // namespace detail

/// The camera of `view` moved around its target: to its right by `turn` about the axis `up`, by `rise`
/// towards `up`, never within a degree of the axis, and to `distance` times its distance. The target stays
/// where it is in the image, and things at its depth show at 1 / `distance` times their size, for which
/// the focal lengths of an orthographic camera change. Angles are in radians. Throws `InvalidArgument`
/// for an `up` of no length, a distance that is not above 0, and angles that are not finite.
inline Camera orbit(const OrbitView& view, double turn, double rise = 0, double distance = 1) {
  using detail::cross, detail::dot, detail::turned;
  const double length = std::sqrt(dot(view.up, view.up));
  if (!(length > 0 && detail::is_finite(length)))
    throw InvalidArgument("orbit: expected an up of a finite length above 0");
  if (!(distance > 0 && detail::is_finite(distance) && detail::is_finite(turn) && detail::is_finite(rise)))
    throw InvalidArgument("orbit: expected finite angles and a finite distance above 0");
  const dvec3 up = view.up / length;
  Camera camera = view.camera;
  const dvec3 seen = camera.rotation * view.target + camera.translation;  // which stays
  const dvec3 offset = camera.centre() - view.target;
  dvec3 right = cross(up, offset);
  const double level = std::sqrt(dot(right, right));
  if (level > 0) {
    constexpr double least = std::numbers::pi / 180;
    const double above = std::atan2(level, dot(up, offset));  // angle to the axis
    right /= level;
    rise =
        above - std::clamp(above - rise, std::min(above, least), std::max(above, std::numbers::pi - least));
  } else {
    rise = 0;
  }
  for (int row = 0; row < 3; ++row) {
    const dvec3 axis(camera.rotation[0][row], camera.rotation[1][row], camera.rotation[2][row]);
    const dvec3 moved = turned(turned(axis, right, -rise), up, turn);
    for (int column = 0; column < 3; ++column) camera.rotation[column][row] = moved[column];
  }
  camera.translation = distance * seen - camera.rotation * view.target;
  if (traits_of(camera.lens.model).parallel_rays) camera.fx /= distance, camera.fy /= distance;
  return camera;
}

}  // namespace swiftgs
