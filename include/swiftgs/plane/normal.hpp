// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include <swiftgs/lens.hpp>
#include <swiftgs/math.hpp>
#include <swiftgs/project.hpp>
#include <swiftgs/scene.hpp>
#include <swiftgs/view_constants.hpp>

namespace swiftgs {

/// The axis along which a Gaussian is shortest; of equal ones the first.
SWIFTGS_HD inline int shortest_axis(vec3 scale) {
  const int first = scale.y < scale.x ? 1 : 0;
  return scale.z < scale[first] ? 2 : first;
}

/// Normal of Gaussian `i` in camera space: a unit vector along its shortest axis that points against the ray
/// through its mean.
SWIFTGS_HD inline vec3 splat_normal(const ViewConstants& v, const SceneView& scene, std::size_t i) {
  const Gaussian g = gaussian(scene, i);
  const vec3 axis = LocalAxes<float>(g.rotation).column[shortest_axis(g.scale)];
  vec3 normal;
  for (int row = 0; row < 3; ++row)
    normal[row] = dot(vec3(v.axes[row][0], v.axes[row][1], v.axes[row][2]), axis);
  vec3 ray(0, 0, 1);
  if (v.lens.model != LensModel::orthographic) {
    const CameraPoint at(v, g.mean);
    ray = vec3(float(at.p[0]), float(at.p[1]), float(at.p[2]));
  }
  return dot(normal, ray) > 0 ? -normal : normal;
}

}  // namespace swiftgs
