// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Converts trained parameters to rendered ones: opacities, rotations, spherical harmonics.

#include <cmath>

#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/scene_view.hpp>

namespace swiftgs {

/// The opacity of a logit.
SWIFTGS_HD inline float sigmoid(float logit) { return 1 / (1 + std::exp(-logit)); }

/// The rotation of a quaternion of any length. Zero, which has no direction, becomes the identity; a
/// quaternion that is not finite yields a NaN.
SWIFTGS_HD inline Quaternion normalised(float w, float x, float y, float z) {
  const double squared = double(w) * w + double(x) * x + double(y) * y + double(z) * z;
  if (squared == 0) return {};
  const double inverse = inverse_sqrt(squared);
  return {float(w * inverse), float(x * inverse), float(y * inverse), float(z * inverse)};
}
SWIFTGS_HD inline Quaternion normalised(Quaternion q) { return normalised(q.w, q.x, q.y, q.z); }

/// Constants of the real spherical harmonics, Condon-Shortley sign folded in. Index l^2 + l + m.
namespace sh {
inline constexpr double c0 = 0.28209479177387814;
inline constexpr double c1 = 0.4886025119029199;
// One by one, because device code cannot index a constant array of the host.
inline constexpr double c20 = 1.0925484305920792;
inline constexpr double c21 = -1.0925484305920792;
inline constexpr double c22 = 0.31539156525252005;
inline constexpr double c23 = -1.0925484305920792;
inline constexpr double c24 = 0.5462742152960396;
inline constexpr double c30 = -0.5900435899266435;
inline constexpr double c31 = 2.890611442640554;
inline constexpr double c32 = -0.4570457994644658;
inline constexpr double c33 = 0.3731763325901154;
inline constexpr double c34 = -0.4570457994644658;
inline constexpr double c35 = 1.445305721320277;
inline constexpr double c36 = -0.5900435899266435;
}  // namespace sh

/// Values of bands 1 to `degree` in the unit direction `d`, from the camera towards the Gaussian.
/// Writes sh_rest_count(degree) values.
template <class T>
SWIFTGS_HD void sh_basis(int degree, Vector3<T> d, T* basis) {
  if (degree < 1) return;
  const T x = d.x, y = d.y, z = d.z;
  basis[0] = -T(sh::c1) * y, basis[1] = T(sh::c1) * z, basis[2] = -T(sh::c1) * x;
  if (degree < 2) return;
  const T xx = x * x, yy = y * y, zz = z * z;
  basis[3] = T(sh::c20) * x * y;
  basis[4] = T(sh::c21) * y * z;
  basis[5] = T(sh::c22) * (2 * zz - xx - yy);
  basis[6] = T(sh::c23) * x * z;
  basis[7] = T(sh::c24) * (xx - yy);
  if (degree < 3) return;
  basis[8] = T(sh::c30) * y * (3 * xx - yy);
  basis[9] = T(sh::c31) * x * y * z;
  basis[10] = T(sh::c32) * y * (4 * zz - xx - yy);
  basis[11] = T(sh::c33) * z * (2 * zz - 3 * xx - 3 * yy);
  basis[12] = T(sh::c34) * x * (4 * zz - xx - yy);
  basis[13] = T(sh::c35) * z * (xx - yy);
  basis[14] = T(sh::c36) * x * (xx - 3 * yy);
}

/// Colour seen in the unit direction `d`, before it is cut below at 0: 0.5 + sum of bands. `rest[k]` are the
/// coefficients of bands 1 to `degree`, RGB innermost.
template <class Rest>
SWIFTGS_HD vec3 sh_colour(int degree, vec3 sh0, const Rest& rest, vec3 d) {
  float basis[sh_rest_count(max_sh_degree)];
  sh_basis(degree, d, basis);
  vec3 colour = vec3(0.5f) + float(sh::c0) * sh0;
  for (int k = 0; k < sh_rest_count(degree); ++k)
    colour += basis[k] * vec3(rest[3 * k], rest[3 * k + 1], rest[3 * k + 2]);
  return colour;
}

/// The same where a term or a partial sum leaves the range of float though the colour does not: infinite or
/// not a number only if the colour is.
template <class Rest>
SWIFTGS_HD vec3 large_sh_colour(int degree, vec3 sh0, const Rest& rest, vec3 d) {
  const float smaller = 0x1p-6f;  // 16 terms of at most 2.9 times the largest float, a sixty-fourth of each
  float basis[sh_rest_count(max_sh_degree)];
  sh_basis(degree, d, basis);
  vec3 colour = vec3(0.5f * smaller) + float(sh::c0) * (smaller * sh0);
  for (int k = 0; k < sh_rest_count(degree); ++k)
    for (int c = 0; c < 3; ++c) colour[c] += basis[k] * (smaller * rest[3 * k + c]);
  return colour / smaller;
}

/// The SH coefficient of band 0 of a Gaussian whose colour is the same from everywhere.
SWIFTGS_HD inline vec3 sh0_of(vec3 colour) {
  const auto coefficient = [](float value) { return float((double(value) - 0.5) / sh::c0); };
  return {coefficient(colour.x), coefficient(colour.y), coefficient(colour.z)};
}

/// The coefficient of band 0 of Gaussian `i`.
SWIFTGS_HD inline vec3 sh0_of(const SceneView& scene, std::size_t i) {
  return scene.plain_colours ? sh0_of(scene.sh0[i]) : scene.sh0[i];
}

/// Colour of Gaussian `i` seen in the unit direction `d`, before it is cut below at 0.
SWIFTGS_HD inline vec3 sh_colour(const SceneView& scene, std::size_t i, vec3 d) {
  return sh_colour(scene.sh_degree, sh0_of(scene, i), scene.sh_rest[i], d);
}

}  // namespace swiftgs
