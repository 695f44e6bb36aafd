// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <utility>

#include <glm/geometric.hpp>

#include <swiftgs/math.hpp>

namespace swiftgs::detail {

/// An ellipsoid's directions, orthonormal and of determinant 1, and half axes, the longest first.
struct PrincipalAxes {
  dmat3 directions;
  dvec3 lengths;
};

/// Axes of the ellipsoid to which the matrix of `columns` maps the unit sphere. One-sided Jacobi rotations
/// make the columns orthogonal and leave the ellipsoid as it is: no square of a short axis is subtracted from
/// that of a long one, as it would be in the covariance.
inline PrincipalAxes principal_axes(dmat3 columns) {
  constexpr int most_sweeps = 30;  // a handful suffices, but for axes that are noise of longer ones
  bool rotated = true;
  for (int sweep = 0; rotated && sweep < most_sweeps; ++sweep) {
    rotated = false;
    for (int i = 0; i < 3; ++i) {
      dvec3 &a = columns[i], &b = columns[(i + 1) % 3];
      const double aa = glm::dot(a, a), bb = glm::dot(b, b), ab = glm::dot(a, b);
      if (!(std::abs(ab) > 1e-15 * std::sqrt(aa) * std::sqrt(bb))) continue;
      const double half = (bb - aa) / (2 * ab);
      const double tangent = std::copysign(1 / (std::abs(half) + std::hypot(1.0, half)), half);
      const double cosine = 1 / std::hypot(1.0, tangent), sine = cosine * tangent;
      const dvec3 turned = cosine * a - sine * b;
      b = sine * a + cosine * b, a = turned;
      rotated = true;
    }
  }

  PrincipalAxes out;
  for (int i = 0; i < 2; ++i)
    for (int j = 2; j > i; --j)
      if (glm::length(columns[j]) > glm::length(columns[j - 1])) std::swap(columns[j], columns[j - 1]);
  for (int i = 0; i < 3; ++i) out.lengths[i] = glm::length(columns[i]);

  // A short axis has the direction that the longer ones leave; of length 0, any such direction.
  dvec3& first = out.directions[0] = out.lengths[0] > 0 ? columns[0] / out.lengths[0] : dvec3(1, 0, 0);
  dvec3& second = out.directions[1] = columns[1] - glm::dot(columns[1], first) * first;
  if (!(glm::length(second) > 0)) {
    dvec3 other(0);
    other[std::abs(first.x) < 0.6 ? 0 : 1] = 1;
    second = other - glm::dot(other, first) * first;
  }
  second = glm::normalize(second);
  out.directions[2] = glm::cross(first, second);
  return out;
}

}  // namespace swiftgs::detail
