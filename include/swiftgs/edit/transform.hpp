// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>

#include <swiftgs/camera.hpp>
#include <swiftgs/edit/affine.hpp>
#include <swiftgs/edit/origin.hpp>
#include <swiftgs/edit/rotation.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/placing.hpp>
#include <swiftgs/scene.hpp>

namespace swiftgs {

namespace detail {

/// What makes the ellipsoid of a Gaussian.
struct Shape {
  dvec3 scale;
  DQuaternion rotation;

  bool is_finite() const {
    const DQuaternion& q = rotation;
    return detail::is_finite(scale) && detail::is_finite(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  }
};

/// The ellipsoid that `linear` makes of one, by its principal axes. The error of a length is relative to that
/// length, however thin the ellipsoid is: about 1e-16 times the quotient of the most and the least that
/// `linear` stretches.
inline Shape stretched(const Shape& shape, const dmat3& linear) {
  dmat3 columns = linear * matrix_of(shape.rotation);
  for (int axis = 0; axis < 3; ++axis) columns[axis] *= shape.scale[axis];
  const PrincipalAxes axes = principal_axes(columns);
  return {axes.lengths, quaternion_of(axes.directions)};
}

/// The same ellipsoid with a rotation of unit length. A quaternion q of another length stands for a matrix
/// that is not orthogonal, and no quaternion for the rotated matrix: the shape gets its principal axes.
inline Shape upright(const Shape& shape) {
  const DQuaternion& q = shape.rotation;
  const double off = std::abs(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z - 1);
  const double rounding = 0x1p-21;  // of four floats, and of what made them
  return off <= rounding || !shape.is_finite() ? shape : stretched(shape, dmat3(1.0));
}

/// Whether `after` is finite where `before` is, and has no more axes of length 0.
inline bool fits(const dvec3& before, const vec3& after) {
  int lost = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (!is_finite(after[axis]) && is_finite(before[axis])) return false;
    lost += (after[axis] == 0) - (before[axis] == 0);
  }
  return lost <= 0;
}

/// Moves means by `by`, harmonics by `rotation` and shapes by `reshape`. `before` is what of a shape
/// `reshape` takes, and what its result is compared with.
template <class Movement, class Before, class Reshape>
void move(Scene& scene, const Movement& by, const dvec3& origin, const dmat3& rotation, const Before& before,
          const Reshape& reshape) {
  const auto moved = [&](std::size_t i) { return vec3(by(scene.origin + dvec3(scene.means[i])) - origin); };
  const auto shape_of = [&](std::size_t i) {
    const Quaternion& q = scene.rotations[i];
    return before(Shape{dvec3(scene.scales[i]), {q.w, q.x, q.y, q.z}});
  };
  const std::size_t stride = 3 * std::size_t(sh_rest_count(scene.sh_degree));
  for (std::size_t i = 0; i < scene.size(); ++i) {
    const Shape shape = shape_of(i);
    bool fit =
        (is_finite(moved(i)) || !is_finite(scene.means[i])) && fits(shape.scale, vec3(reshape(shape).scale));
    // A rotation makes no coefficient of band 3 more than sqrt(7) times as large as the largest was.
    for (std::size_t k = 0; k < stride; ++k) {
      const float coefficient = std::abs(scene.sh_rest[i * stride + k]);
      fit = fit && (!is_finite(coefficient) || coefficient < 1e38f);
    }
    if (!fit)
      throw detail::ErrorAs<std::range_error>(
          ErrorCode::invalid_argument,
          "transform: Gaussian " + std::to_string(i) +
              " would leave the range of float; expected a movement that keeps it there");
  }

  const ShRotation harmonics(rotation, scene.sh_degree);
  for (std::size_t i = 0; i < scene.size(); ++i) {
    const Shape after = reshape(shape_of(i));
    scene.means[i] = moved(i), scene.scales[i] = vec3(after.scale);
    scene.rotations[i] = rounded(after.rotation);
    if (stride != 0) harmonics.apply(scene.sh_rest.data() + i * stride);
  }
  scene.origin = origin;
}

/// The origin that `OriginChoice` gives a scene that `by` moves, which lengthens no axis more than `most`
/// times.
template <class Movement>
dvec3 origin_for(const Scene& scene, const Movement& by, double most) {
  OriginChoice choice;
  OriginChoice::for_each_sample(scene.size(), [&](std::size_t i) {
    const vec3& scale = scene.scales[i];
    choice.add(by(scene.origin + dvec3(scene.means[i])), float(most * std::max({scale.x, scale.y, scale.z})));
  });
  return choice.origin();
}

}  // namespace detail

/// The origin that `OriginChoice` gives a scene that `by` moves. Throws as `validate` does of the scene and
/// the movement.
inline dvec3 origin_for(const Scene& scene, const Similarity& by = {}) {
  validate(scene), validate(by);
  return detail::origin_for(scene, by, by.scale);
}
inline dvec3 origin_for(const Scene& scene, const Affine& by) {
  validate(scene), validate(by);
  return detail::origin_for(scene, by, detail::principal_axes(by.linear).lengths[0]);
}

/// Moves all Gaussians: means, scales, rotations, and harmonics in all bands. Computed in double and rounded
/// to float once, relative to `origin`, which becomes the scene's; `origin_for` chooses one. Where the
/// movement rotates, rotations that are not of unit length become so, with the scales of the same ellipsoid.
/// Linear in the number of Gaussians. Throws `InvalidArgument` as `validate` does of the scene and the
/// movement, and `std::range_error` if a mean, scale or coefficient would leave the range of float, or a
/// scale become 0; then nothing has moved. Numbers that are NaN or infinite stay so.
inline void transform(Scene& scene, const Similarity& by, const dvec3& origin) {
  using detail::Shape;
  validate(scene), validate(by);
  const DQuaternion turn = quaternion_of(by.rotation);
  const bool turns = by.rotation != dmat3(1.0);
  detail::move(
      scene, by, origin, by.rotation,
      [&](const Shape& shape) { return turns ? detail::upright(shape) : shape; },
      [&](const Shape& shape) {
        return Shape{by.scale * shape.scale, turn * shape.rotation};
      });
}

/// The same with the origin that `origin_for` chooses, if the scene has one. A scene without an origin stays
/// so, that its cameras still fit: the farther from zero, the coarser.
inline void transform(Scene& scene, const Similarity& by) {
  transform(scene, by, scene.origin == dvec3(0.0) ? scene.origin : origin_for(scene, by));
}

/// Moves all Gaussians as `transform` does, by a movement that may stretch and shear: a covariance S becomes
/// L S L^T, where L is `by.linear`. Scales and rotations are then those of the principal axes, the longest
/// first. Harmonics are rotated by `rotation_of(by)`, as no harmonics look stretched. A movement that is a
/// similarity does what `transform` does.
inline void stretch(Scene& scene, const Affine& by, const dvec3& origin) {
  using detail::Shape;
  validate(by);
  if (const auto similar = similarity_of(by)) return transform(scene, *similar, origin);
  validate(scene);
  const dmat3 rotation = rotation_of(by);
  const DQuaternion turn = quaternion_of(rotation);
  detail::move(scene, by, origin, rotation, detail::upright, [&](const Shape& shape) {
    return shape.is_finite() ? detail::stretched(shape, by.linear)
                             : Shape{shape.scale, turn * shape.rotation};
  });
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
