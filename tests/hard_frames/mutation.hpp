// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <stdexcept>

#include <swiftgs/edit/select.hpp>

#include "hard_frames/lone.hpp"
#include "hard_frames/thresholds.hpp"

/// @file
/// Small changes of a frame, for a search.

namespace swiftgs::stress {

/// How the camera sees the longest axis of a Gaussian.
struct LongestAxis {
  double scale = 0;
  double depth = 0;
  dvec3 axis{0.0}, ray{0.0};  ///< of length 1, in the world; at an angle of 90 degrees or less

  LongestAxis(const StressCase& drawn, std::size_t i) {
    const vec3 s = drawn.scene.scales[i], m = drawn.scene.means[i];
    const Quaternion q = drawn.scene.rotations[i];
    const int k = s.x >= s.y && s.x >= s.z ? 0 : s.y >= s.z ? 1 : 2;
    const Camera& camera = drawn.camera;
    const dvec3 mean{double(m.x), double(m.y), double(m.z)};
    scale = double(s[k]);
    axis = matrix_of(unit({double(q.w), double(q.x), double(q.y), double(q.z)}))[k];
    ray = unit_vector(mean - camera.centre());
    depth = camera.translation.z;
    for (int column = 0; column < 3; ++column) depth += camera.rotation[column].z * mean[column];
    if (detail::dot(axis, ray) < 0) axis = -axis;
  }
  double sine() const {
    const dvec3 c = detail::cross(axis, ray);
    return std::sqrt(detail::dot(c, c));
  }
};

/// Moves a number by one float, by a few, by a small part of itself, or by much.
inline void move_number(Random& random, float& value) {
  const float sign = random.below(2) ? 1 : -1;
  switch (random.below(5)) {
    case 0:
      value = stepped(value, random.below(2) ? 1 : -1);
      return;
    case 1:
      value = stepped(value, random.below(33) - 16);
      return;
    case 2:
      value *= 1 + sign * float(random.scale(1e-7, 1e-3));
      return;
    case 3:
      value *= 1 + sign * float(random.scale(1e-3, 0.5));
      return;
    default:
      value *= float(random.scale(0.1, 10));
      if (random.below(8) == 0) value = -value;
  }
}

inline void move_number(Random& random, double& value) {
  const double sign = random.below(2) ? 1 : -1;
  value *= random.below(3) ? 1 + sign * random.scale(1e-9, 0.5) : random.scale(0.1, 10);
}

inline void turn_gaussian(Quaternion& q, const DQuaternion& by) {
  q = rounded(unit(by * DQuaternion{double(q.w), double(q.x), double(q.y), double(q.z)}));
}

/// Changes Gaussian `i`.
inline void move_gaussian(Random& random, StressCase& drawn, std::size_t i) {
  Scene& scene = drawn.scene;
  Quaternion& q = scene.rotations[i];
  const std::array<float*, 14> numbers{&scene.means[i].x,
                                       &scene.means[i].y,
                                       &scene.means[i].z,
                                       &scene.scales[i].x,
                                       &scene.scales[i].y,
                                       &scene.scales[i].z,
                                       &q.w,
                                       &q.x,
                                       &q.y,
                                       &q.z,
                                       &scene.opacities[i],
                                       &scene.sh0[i].x,
                                       &scene.sh0[i].y,
                                       &scene.sh0[i].z};
  switch (random.below(8)) {
    case 0: {
      const double half = random.scale(1e-8, 1), s = std::sin(half);
      const double z = random.in(0.01, 1), y = random.in(-1, 1), x = random.in(-1, 1);
      const dvec3 axis = unit_vector({x, y, z});
      return turn_gaussian(q, {std::cos(half), s * axis.x, s * axis.y, s * axis.z});
    }
    case 1: {  // halves the angle between the longest axis and the ray
      const LongestAxis longest(drawn, i);
      return turn_gaussian(q, turn_between(longest.axis, unit_vector(longest.axis + longest.ray)));
    }
    case 2: {  // one scale, or all
      const int axis = random.below(4);
      const auto factor = float(random.scale(0.1, 10));
      for (int k = 0; k < 3; ++k) scene.scales[i][k] *= axis == 3 || axis == k ? factor : 1;
      return;
    }
    default:
      move_number(random, *numbers[std::size_t(random.below(int(numbers.size())))]);
  }
}

/// Changes the camera or the blur.
inline void move_camera(Random& random, StressCase& drawn) {
  Camera& c = drawn.camera;
  const std::array<double*, 7> numbers{
      &c.fx, &c.fy, &c.cx, &c.cy, &c.translation.x, &c.translation.y, &c.translation.z};
  switch (random.below(6)) {
    case 0: {
      float blur = *as_trained(drawn.conventions, drawn.scene.model).blur;
      move_number(random, blur);
      drawn.conventions.blur = blur;
      return;
    }
    case 1:
      c.fy = c.fx;
      return;
    case 2: {
      const double scale = random.scale(0.5, 2);
      c.fx *= scale, c.fy *= scale;
      return;
    }
    default:
      move_number(random, *numbers[std::size_t(random.below(int(numbers.size())))]);
  }
}

/// Whether the frame is within the limits of `Scene`, `Camera` and `Conventions`.
inline bool is_valid(const StressCase& drawn) {
  try {
    validate(drawn.camera), validate(drawn.conventions), validate(drawn.scene);
    validate_numbers(drawn.scene);
  } catch (const std::invalid_argument&) {
    return false;
  }
  for (std::size_t i = 0; i < drawn.scene.size(); ++i) {
    const vec3 s = drawn.scene.scales[i];
    const Quaternion q = drawn.scene.rotations[i];
    const float opacity = drawn.scene.opacities[i], length = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
    if (!(s.x >= 0 && s.y >= 0 && s.z >= 0 && opacity >= 0 && opacity <= 1)) return false;
    if (!(length >= 0.5f && length <= 2)) return false;
  }
  return true;
}

/// `parent` with one to four changes, which may leave the limits.
inline StressCase mutated(Random& random, const StressCase& parent) {
  StressCase out = parent;
  const int changes = 1 + random.below(4);
  for (int change = 0; change < changes; ++change) {
    if (out.scene.size() > 1 && random.below(16) == 0) {
      const auto removed = std::uint32_t(random.below(int(out.scene.size())));
      out.scene = subset(out.scene, select(out.scene, [&](std::size_t i) { return i != removed; }));
    } else if (out.scene.size() == 0 || random.below(4) == 0)
      move_camera(random, out);
    else
      move_gaussian(random, out, std::size_t(random.below(int(out.scene.size()))));
  }
  return out;
}

}  // namespace swiftgs::stress
