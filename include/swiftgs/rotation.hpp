// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Rotations in double, as matrices and as quaternions.

#include <cmath>

#include <swiftgs/math.hpp>

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
