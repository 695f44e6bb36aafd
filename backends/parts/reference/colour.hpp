// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Core>

#include <swiftgs/scene.hpp>

namespace swiftgs::reference {

/// The real spherical harmonics of bands 0 to 3 at the unit vector `d`, index l^2 + l + m, with the
/// Condon-Shortley sign folded in.
inline std::array<double, 16> sh_basis(const Eigen::Vector3d& d) {
  const double x = d.x(), y = d.y(), z = d.z();
  const double xx = x * x, yy = y * y, zz = z * z;
  return {0.28209479177387814,
          -0.4886025119029199 * y,
          0.4886025119029199 * z,
          -0.4886025119029199 * x,
          1.0925484305920792 * x * y,
          -1.0925484305920792 * y * z,
          0.31539156525252005 * (2 * zz - xx - yy),
          -1.0925484305920792 * x * z,
          0.5462742152960396 * (xx - yy),
          -0.5900435899266435 * y * (3 * xx - yy),
          2.890611442640554 * x * y * z,
          -0.4570457994644658 * y * (4 * zz - xx - yy),
          0.3731763325901154 * z * (2 * zz - 3 * xx - 3 * yy),
          -0.4570457994644658 * x * (4 * zz - xx - yy),
          1.445305721320277 * z * (xx - yy),
          -0.5900435899266435 * x * (xx - 3 * yy)};
}

/// Colour of Gaussian `i` seen along the unit vector `direction`, from the camera towards the Gaussian,
/// before it is cut below at 0: all stored bands, + 0.5.
inline Eigen::Vector3d colour(const Scene& scene, std::size_t i, const Eigen::Vector3d& direction) {
  const std::array<double, 16> basis = sh_basis(direction);
  const vec3& dc = scene.sh0[i];
  Eigen::Vector3d sum = basis[0] * Eigen::Vector3d(dc.x, dc.y, dc.z);
  const std::size_t count = std::size_t(sh_rest_count(scene.sh_degree));
  for (std::size_t k = 0; k < count; ++k)
    sum +=
        basis[k + 1] * Eigen::Map<const Eigen::Vector3f>(&scene.sh_rest[3 * (i * count + k)]).cast<double>();
  return sum.array() + 0.5;
}

}  // namespace swiftgs::reference
