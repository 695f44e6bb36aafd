// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Rotations in double: matrices, quaternions, axes of ellipsoids, and spherical harmonics.

#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include <glm/geometric.hpp>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/project/sh.hpp>

namespace swiftgs {

/// Hamilton quaternion in double, scalar part first.
struct DQuaternion {
  double w = 1, x = 0, y = 0, z = 0;
};

/// The nearest quaternion in float.
inline Quaternion rounded(const DQuaternion& q) { return {float(q.w), float(q.x), float(q.y), float(q.z)}; }

/// The same rotation with length 1. A quaternion of zeros stays zero. Squares of the parts must be in the
/// range of double.
inline DQuaternion unit(const DQuaternion& q) {
  const double length = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  const double scale = length > 0 ? 1 / length : 1;
  return {q.w * scale, q.x * scale, q.y * scale, q.z * scale};
}

/// The rotation by b, then by a.
inline DQuaternion operator*(const DQuaternion& a, const DQuaternion& b) {
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}

/// Unit quaternion of an orthonormal matrix of determinant 1. GLM stores it by columns: m[column][row].
inline DQuaternion quaternion_of(const dmat3& m) {
  // Four ways, which differ in the part that they divide by: take one where it is not small.
  const double trace = m[0][0] + m[1][1] + m[2][2];
  if (trace > 0) return unit({1 + trace, m[1][2] - m[2][1], m[2][0] - m[0][2], m[0][1] - m[1][0]});
  if (m[0][0] >= m[1][1] && m[0][0] >= m[2][2])
    return unit({m[1][2] - m[2][1], 1 + m[0][0] - m[1][1] - m[2][2], m[0][1] + m[1][0], m[0][2] + m[2][0]});
  if (m[1][1] >= m[2][2])
    return unit({m[2][0] - m[0][2], m[0][1] + m[1][0], 1 + m[1][1] - m[0][0] - m[2][2], m[1][2] + m[2][1]});
  return unit({m[0][1] - m[1][0], m[0][2] + m[2][0], m[1][2] + m[2][1], 1 + m[2][2] - m[0][0] - m[1][1]});
}

/// Rotation matrix of a unit quaternion.
inline dmat3 matrix_of(const DQuaternion& q) {
  const double xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z;
  const double xy = q.x * q.y, xz = q.x * q.z, yz = q.y * q.z, wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
  return dmat3(dvec3(1 - 2 * (yy + zz), 2 * (xy + wz), 2 * (xz - wy)),
               dvec3(2 * (xy - wz), 1 - 2 * (xx + zz), 2 * (yz + wx)),
               dvec3(2 * (xz + wy), 2 * (yz - wx), 1 - 2 * (xx + yy)));
}

}  // namespace swiftgs

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

namespace swiftgs {

/// Rotates spherical harmonics: with the rotated coefficients, a Gaussian looks along a rotated direction as
/// it did along the direction itself. Exact in all bands, up to the rounding of coefficients to float.
class ShRotation {
 public:
  /// For bands 1 to `degree`, 0 to 3, and an orthonormal matrix, which may be a mirror. Throws
  /// `InvalidArgument` for any other degree.
  ShRotation(const dmat3& rotation, int degree) : degree_(degree) {
    if (degree < 0 || degree > max_sh_degree)
      detail::refuse("ShRotation: degree is ", degree, ", expected 0 to 3");
    // Entry (m, n) of a band's matrix is the integral of Y_m(R d) Y_n(d) over all directions d. A product of
    // two functions of band 3 is a polynomial of degree 6, and this rule is exact up to degree 7: Gauss and
    // Legendre's four heights, with eight directions at each.
    constexpr double heights[] = {-0.86113631159405258, -0.33998104358485626, 0.33998104358485626,
                                  0.86113631159405258};
    constexpr double weights[] = {0.34785484513745386, 0.65214515486254614, 0.65214515486254614,
                                  0.34785484513745386};
    constexpr int around = 8;
    constexpr double turn = 2 * 3.14159265358979323846 / around;
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < around; ++j) {
        const double z = heights[i], radius = std::sqrt(1 - z * z);
        const dvec3 from(radius * std::cos(turn * j), radius * std::sin(turn * j), z);
        double before[sh_rest_count(max_sh_degree)], after[sh_rest_count(max_sh_degree)];
        sh_basis(degree, from, before);
        sh_basis(degree, rotation * from, after);
        for_each_entry(entries_, [&](double& entry, int m, int n) {
          entry += weights[i] * turn * after[m] * before[n];
        });
      }
  }

  /// Rotates the coefficients of a Gaussian in place. @shape{sh_rest_count(degree), 3}
  void apply(float* rest) const {
    std::array<double, 3 * sh_rest_count(max_sh_degree)> rotated{};
    for_each_entry(entries_, [&](double entry, int m, int n) {
      for (int channel = 0; channel < 3; ++channel)
        rotated[std::size_t(3 * m + channel)] += entry * double(rest[3 * n + channel]);
    });
    for (int k = 0; k < 3 * sh_rest_count(degree_); ++k) rest[k] = float(rotated[std::size_t(k)]);
  }

 private:
  /// f(entry, m, n) for each entry of each band's matrix; m and n count from the first function of band 1.
  template <class Entries, class F>
  void for_each_entry(Entries& entries, const F& f) const {
    std::size_t k = 0;
    for (int band = 1; band <= degree_; ++band)
      for (int m = sh_rest_count(band - 1); m < sh_rest_count(band); ++m)
        for (int n = sh_rest_count(band - 1); n < sh_rest_count(band); ++n) f(entries[k++], m, n);
  }

  int degree_;
  std::array<double, 9 + 25 + 49> entries_{};
};

}  // namespace swiftgs
