// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include <swiftgs/frame/math.hpp>

/// @file
/// Rotations of placed scenes as the angles that panels show.

namespace swiftgs::cli {

/// The rotation by angles about the axes x, then y, then z of the world. @units{degrees}
inline dmat3 rotation_of(const dvec3& angles) {
  const dvec3 radians = angles * (std::numbers::pi / 180);
  const double cx = std::cos(radians.x), sx = std::sin(radians.x), cy = std::cos(radians.y),
               sy = std::sin(radians.y), cz = std::cos(radians.z), sz = std::sin(radians.z);
  return dmat3(dvec3(cz * cy, sz * cy, -sy), dvec3(cz * sy * sx - sz * cx, sz * sy * sx + cz * cx, cy * sx),
               dvec3(cz * sy * cx + sz * sx, sz * sy * cx - cz * sx, cy * cx));
}

/// Angles of `rotation`, as `rotation_of` takes them.
inline dvec3 angles_of(const dmat3& rotation) {
  const double to_degrees = 180 / std::numbers::pi;
  // 0, not -0.
  return 0.0 + to_degrees * dvec3(std::atan2(rotation[1][2], rotation[2][2]),
                                  std::asin(std::clamp(-rotation[0][2], -1.0, 1.0)),
                                  std::atan2(rotation[0][1], rotation[0][0]));
}

}  // namespace swiftgs::cli
