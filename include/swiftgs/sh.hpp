// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <swiftgs/math.hpp>
#include <swiftgs/scene.hpp>

namespace swiftgs {

/// Constants of the real spherical harmonics, Condon-Shortley sign folded in. Index l^2 + l + m.
namespace sh {
inline constexpr float c0 = 0.28209479177387814f;
inline constexpr float c1 = 0.4886025119029199f;
// One by one, because device code cannot index a constant array of the host.
inline constexpr float c20 = 1.0925484305920792f;
inline constexpr float c21 = -1.0925484305920792f;
inline constexpr float c22 = 0.31539156525252005f;
inline constexpr float c23 = -1.0925484305920792f;
inline constexpr float c24 = 0.5462742152960396f;
inline constexpr float c30 = -0.5900435899266435f;
inline constexpr float c31 = 2.890611442640554f;
inline constexpr float c32 = -0.4570457994644658f;
inline constexpr float c33 = 0.3731763325901154f;
inline constexpr float c34 = -0.4570457994644658f;
inline constexpr float c35 = 1.445305721320277f;
inline constexpr float c36 = -0.5900435899266435f;
}  // namespace sh

/// Values of bands 1 to `degree` in the unit direction `d`, from the camera towards the Gaussian.
/// Writes sh_rest_count(degree) values.
SWIFTGS_HD inline void sh_basis(int degree, vec3 d, float* basis) {
  if (degree < 1) return;
  const float x = d.x, y = d.y, z = d.z;
  basis[0] = -sh::c1 * y, basis[1] = sh::c1 * z, basis[2] = -sh::c1 * x;
  if (degree < 2) return;
  const float xx = x * x, yy = y * y, zz = z * z;
  basis[3] = sh::c20 * x * y;
  basis[4] = sh::c21 * y * z;
  basis[5] = sh::c22 * (2 * zz - xx - yy);
  basis[6] = sh::c23 * x * z;
  basis[7] = sh::c24 * (xx - yy);
  if (degree < 3) return;
  basis[8] = sh::c30 * y * (3 * xx - yy);
  basis[9] = sh::c31 * x * y * z;
  basis[10] = sh::c32 * y * (4 * zz - xx - yy);
  basis[11] = sh::c33 * z * (2 * zz - 3 * xx - 3 * yy);
  basis[12] = sh::c34 * x * (4 * zz - xx - yy);
  basis[13] = sh::c35 * z * (xx - yy);
  basis[14] = sh::c36 * x * (xx - 3 * yy);
}

/// Colour seen in the unit direction `d`, before it is cut below at 0: 0.5 + sum of bands. `rest` holds the
/// coefficients of bands 1 to `degree`, RGB innermost.
SWIFTGS_HD inline vec3 sh_colour(int degree, vec3 sh0, const float* rest, vec3 d) {
  float basis[sh_rest_count(max_sh_degree)];
  sh_basis(degree, d, basis);
  vec3 colour = vec3(0.5f) + sh::c0 * sh0;
  for (int k = 0; k < sh_rest_count(degree); ++k)
    colour += basis[k] * vec3(rest[3 * k], rest[3 * k + 1], rest[3 * k + 2]);
  return colour;
}

/// Colour of Gaussian `i` seen in the unit direction `d`, before it is cut below at 0.
SWIFTGS_HD inline vec3 sh_colour(const SceneView& scene, std::size_t i, vec3 d) {
  return sh_colour(scene.sh_degree, scene.sh0[i], scene.sh_rest.data + i * std::size_t(scene.sh_stride), d);
}

}  // namespace swiftgs
