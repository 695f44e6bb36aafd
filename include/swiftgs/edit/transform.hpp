// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>

#include <swiftgs/camera.hpp>
#include <swiftgs/edit/origin.hpp>
#include <swiftgs/edit/principal_axes.hpp>
#include <swiftgs/edit/sh_rotation.hpp>
#include <swiftgs/finite.hpp>
#include <swiftgs/math.hpp>
#include <swiftgs/rotation.hpp>
#include <swiftgs/scene.hpp>
#include <swiftgs/similarity.hpp>

namespace swiftgs {

namespace detail {

/// What makes the ellipsoid of a Gaussian.
struct Shape {
  dvec3 scale;
  DQuaternion rotation;
};

/// The shape that the rotation of `by` makes of one; `turn` is that rotation. A quaternion q that is not of
/// unit length stands for a matrix that is not orthogonal, and no quaternion for the rotated matrix: the
/// shape gets its principal axes.
inline Shape rotated(const Shape& shape, const Similarity& by, const DQuaternion& turn) {
  const DQuaternion& q = shape.rotation;
  const double off = std::abs(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z - 1);
  const double rounding = 0x1p-21;  // of four floats, and of what made them
  const bool finite = is_finite(off) && is_finite(vec3(shape.scale));
  if (off <= rounding || !finite || by.rotation == dmat3(1.0)) return {shape.scale, turn * q};
  dmat3 columns = matrix_of(q);
  for (int axis = 0; axis < 3; ++axis) columns[axis] *= shape.scale[axis];
  const PrincipalAxes axes = principal_axes(columns);
  return {axes.lengths, turn * quaternion_of(axes.directions)};
}

}  // namespace detail

/// The origin that `OriginChoice` gives a scene that `by` moves.
inline dvec3 origin_for(const Scene& scene, const Similarity& by = {}) {
  validate(scene), validate(by);
  OriginChoice choice;
  OriginChoice::for_each_sample(scene.size(), [&](std::size_t i) {
    const vec3& scale = scene.scales[i];
    choice.add(by(scene.origin + dvec3(scene.means[i])),
               float(by.scale * std::max({scale.x, scale.y, scale.z})));
  });
  return choice.origin();
}

/// Moves all Gaussians: means, scales, rotations, and harmonics in all bands. Computed in double and rounded
/// to float once, relative to `origin`, which becomes the scene's; `origin_for` chooses one. Where the
/// movement rotates, rotations that are not of unit length become so, with the scales of the same ellipsoid.
/// Linear in the number of Gaussians. Throws `std::invalid_argument` as `validate` does of the scene and the
/// movement, and `std::range_error` if a mean, scale or coefficient would leave the range of float, or a
/// scale become 0; then nothing has moved. Numbers that are NaN or infinite stay so.
inline void transform(Scene& scene, const Similarity& by, const dvec3& origin) {
  validate(scene), validate(by);
  const DQuaternion turn = quaternion_of(by.rotation);
  const auto moved = [&](std::size_t i) { return vec3(by(scene.origin + dvec3(scene.means[i])) - origin); };
  const auto shape = [&](std::size_t i) {
    const Quaternion& q = scene.rotations[i];
    return detail::rotated({dvec3(scene.scales[i]), {q.w, q.x, q.y, q.z}}, by, turn);
  };
  const std::size_t stride = 3 * std::size_t(sh_rest_count(scene.sh_degree));
  for (std::size_t i = 0; i < scene.size(); ++i) {
    bool fits = detail::is_finite(moved(i)) || !detail::is_finite(scene.means[i]);
    const dvec3 before = shape(i).scale;
    for (int axis = 0; axis < 3; ++axis) {
      const float after = float(by.scale * before[axis]);
      fits = fits && (detail::is_finite(after) || !detail::is_finite(before[axis])) &&
             (after != 0 || before[axis] == 0);
    }
    // A rotation makes no coefficient of band 3 more than sqrt(7) times as large as the largest was.
    for (std::size_t k = 0; k < stride; ++k) {
      const float coefficient = std::abs(scene.sh_rest[i * stride + k]);
      fits = fits && (!detail::is_finite(coefficient) || coefficient < 1e38f);
    }
    if (!fits)
      throw std::range_error("transform: Gaussian " + std::to_string(i) +
                             " would leave the range of float; expected a movement that keeps it there");
  }

  const ShRotation harmonics(by.rotation, scene.sh_degree);
  for (std::size_t i = 0; i < scene.size(); ++i) {
    const detail::Shape after = shape(i);
    scene.means[i] = moved(i), scene.scales[i] = vec3(by.scale * after.scale);
    scene.rotations[i] = rounded(after.rotation);
    if (stride != 0) harmonics.apply(scene.sh_rest.data() + i * stride);
  }
  scene.origin = origin;
}

/// The same with the origin that `origin_for` chooses, if the scene has one. A scene without an origin stays
/// so, that its cameras still fit: the farther from zero, the coarser.
inline void transform(Scene& scene, const Similarity& by) {
  transform(scene, by, scene.origin == dvec3(0.0) ? scene.origin : origin_for(scene, by));
}

/// The camera that sees a transformed scene as `camera` sees the scene. Depths grow by the scale; the near
/// plane stays where it is. Throws as `validate` does of the movement.
inline Camera transformed(Camera camera, const Similarity& by) {
  validate(by);
  camera.rotation = camera.rotation * glm::transpose(by.rotation);
  camera.translation = by.scale * camera.translation - camera.rotation * by.translation;
  return camera;
}

}  // namespace swiftgs
