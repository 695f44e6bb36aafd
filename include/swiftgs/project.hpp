// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <optional>

#include <swiftgs/bounds/bounds.hpp>
#include <swiftgs/math.hpp>
#include <swiftgs/scene.hpp>
#include <swiftgs/sh.hpp>
#include <swiftgs/splats.hpp>
#include <swiftgs/view_constants.hpp>

namespace swiftgs {

/// All of a Gaussian but its colour.
struct Gaussian {
  vec3 mean, scale;
  Quaternion rotation;
  float opacity;
};
SWIFTGS_HD inline Gaussian gaussian(const SceneView& scene, std::size_t i) {
  return {scene.means[i], scene.scales[i], scene.rotations[i], scene.opacities[i]};
}

/// A splat without its colour.
struct ProjectedShape {
  SplatShape shape;
  float depth = 0;
  bool visible = false;
};

/// Rows of J W R S: how a Gaussian's own unit sphere maps to the image. @units{pixels}
struct ImageAxes {
  vec3 x, y;
  vec3 cross;  ///< x cross y, up to the sign of its elements @units{pixels^2}
};

/// Columns of the rotation matrix of `q` as it is given, unit or not.
struct LocalAxes {
  vec3 column[3];

  SWIFTGS_HD explicit LocalAxes(Quaternion q) {
    const float x2 = 2 * q.x, y2 = 2 * q.y, z2 = 2 * q.z;
    const float wx = q.w * x2, wy = q.w * y2, wz = q.w * z2;
    column[0] =
        vec3(std::fma(-y2, q.y, std::fma(-z2, q.z, 1.0f)), std::fma(x2, q.y, wz), std::fma(x2, q.z, -wy));
    column[1] =
        vec3(std::fma(x2, q.y, -wz), std::fma(-x2, q.x, std::fma(-z2, q.z, 1.0f)), std::fma(y2, q.z, wx));
    column[2] =
        vec3(std::fma(x2, q.z, wy), std::fma(y2, q.z, -wx), std::fma(-x2, q.x, std::fma(-y2, q.y, 1.0f)));
  }
};

/// Axes of a Gaussian at camera-space direction (tx, ty, 1) and depth 1 / inverse_z, by the linearised
/// projection (Zwicker et al. 2001, EWA splatting, equation 29).
///
/// Far off the axis the two rows are nearly parallel, and their cross product would cancel. It is made of
/// cofactors instead: for rows W0, W1, W2 of the camera's rotation
///   (W0 - tx W2) cross (W1 - ty W2) = C2 + tx C0 + ty C1,   C the cofactors of W,
/// and the cofactors of the matrix of a quaternion (w, v) are that matrix + 4 (|q|^2 - 1) v v^T.
SWIFTGS_HD inline ImageAxes image_axes(const ViewConstants& v, float tx, float ty, float inverse_z,
                                       vec3 scale, Quaternion q) {
  vec3 row_x, row_y, normal;
  for (int k = 0; k < 3; ++k) {
    row_x[k] = std::fma(-tx, v.axes[2][k], v.axes[0][k]);
    row_y[k] = std::fma(-ty, v.axes[2][k], v.axes[1][k]);
    normal[k] = std::fma(tx, v.cofactors[0][k], std::fma(ty, v.cofactors[1][k], v.cofactors[2][k]));
  }
  const vec3 turn(q.x, q.y, q.z);
  const float excess = std::fma(q.w, q.w, dot(turn, turn)) - 1;
  const float along = 4 * excess * dot(turn, normal);

  const LocalAxes axes(q);
  const vec3 scale_x = v.focal_x * inverse_z * scale, scale_y = v.focal_y * inverse_z * scale;
  ImageAxes image;
  for (int k = 0; k < 3; ++k) {
    const vec3 axis = axes.column[k];
    image.x[k] = scale_x[k] * dot(row_x, axis);
    image.y[k] = scale_y[k] * dot(row_y, axis);
    const float across = std::fma(along, turn[k], dot(axis, normal));
    image.cross[k] = scale_x[(k + 1) % 3] * scale_y[(k + 2) % 3] * across;
  }
  return image;
}

/// How far beyond its box a splat is visible in a part of an image. Rounding may keep a pixel outside of the
/// box; the image shows it, so its parts must. Twice the slack of bounds, and thus visible wherever they list
/// the splat for such a pixel. @units{pixels}
SWIFTGS_HD inline float part_slack(float half_width, float half_height) {
  return 2 * bounds_slack(half_width, half_height);
}

/// Projects a Gaussian. `visible` is false where no shown pixel can keep it: too near or far, too
/// faint, or the box of its ellipse s <= reach holds no pixel centre. Spherical harmonics are not looked at.
SWIFTGS_HD inline ProjectedShape project_shape(const ViewConstants& v, const Gaussian& g) {
  ProjectedShape out;
  float opacity = g.opacity;
  if (!(opacity >= v.alpha_min && opacity < INFINITY)) return out;

  // Move to camera space in double, so that distant worlds and long focal lengths keep their pixels.
  const vec3 mean = g.mean;
  const double d[3] = {mean.x - v.centre[0], mean.y - v.centre[1], mean.z - v.centre[2]};
  double p[3];
  for (int row = 0; row < 3; ++row)
    p[row] =
        std::fma(v.rotation[row][0], d[0], std::fma(v.rotation[row][1], d[1], v.rotation[row][2] * d[2]));
  const float z = float(p[2]);
  if (!(z > v.near_plane && z <= v.far_plane)) return out;
  const double inverse_z = inverse(p[2]), x_over_z = p[0] * inverse_z, y_over_z = p[1] * inverse_z;

  // Linearise within the limits of the conventions.
  float tx = float(x_over_z), ty = float(y_over_z);
  tx = tx < v.tan_x_min ? v.tan_x_min : tx > v.tan_x_max ? v.tan_x_max : tx;
  ty = ty < v.tan_y_min ? v.tan_y_min : ty > v.tan_y_max ? v.tan_y_max : ty;
  const ImageAxes m = image_axes(v, tx, ty, float(inverse_z), g.scale, g.rotation);

  // Factor the blurred covariance. Its determinant is |m.x cross m.y|^2 + blur (trace + blur), a sum of
  // squares (Lagrange's identity); the textbook xx yy - xy^2 loses all digits of a needle's. Where it loses
  // none it is better: rows that are hardly correlated have a width of x that the rounding of y's row does
  // not move, but that of their cross product does, as with a disk that is seen edge-on.
  const float xx = dot(m.x, m.x), yy = dot(m.y, m.y), xy = dot(m.x, m.y);
  const float var_y = yy + v.blur;
  const float inv_sigma_y = inverse_sqrt(var_y);
  const vec3 c = m.cross * inv_sigma_y;
  const float crossed = dot(c, c);
  const float unshared = xx * (yy * inv_sigma_y * inv_sigma_y), shared = xy * inv_sigma_y;
  // Determinant without blur / var_y.
  const float sharp = 2 * shared * shared > unshared ? crossed : std::fma(-shared, shared, unshared);
  const float inv_var_y = inv_sigma_y * inv_sigma_y;
  const float var_x_given_y = std::fma(v.blur, (xx + var_y) * inv_var_y, sharp);
  if (!(var_x_given_y > 0 && var_y > 0 && xx + v.blur <= largest_variance && var_y <= largest_variance &&
        var_x_given_y < INFINITY))
    return out;

  if (v.antialiased) {
    const float ratio = sharp / var_x_given_y;
    opacity *= std::sqrt(ratio > v.min_compensation ? ratio : v.min_compensation);
    if (!(opacity >= v.alpha_min)) return out;
  }

  const float to_base_2 = float(0.84932180028801904272);  // sqrt(log2(e) / 2)
  SplatShape& s = out.shape;
  s.mean = vec2(float(std::fma(v.fx, x_over_z, v.cx)), float(std::fma(v.fy, y_over_z, v.cy)));
  s.l0 = to_base_2 * inverse_sqrt(var_x_given_y);
  s.l1 = -s.l0 * (xy * inv_var_y);
  s.l2 = to_base_2 * inv_sigma_y;
  s.opacity = opacity;
  s.reach = std::log2(opacity / v.alpha_min);
  const float extent = std::sqrt(s.reach) * (1 / to_base_2);
  s.half_width = extent * std::sqrt(xx + v.blur);
  const float half_height = extent * (var_y * inv_sigma_y);

  out.depth = z;
  out.visible = s.mean.x + s.half_width >= 0.5f && s.mean.x - s.half_width <= v.width - 0.5f &&
                s.mean.y + half_height >= 0.5f && s.mean.y - half_height <= v.height - 0.5f;
  const float slack = part_slack(s.half_width, half_height);
  const float x = s.half_width + slack, y = half_height + slack;
  out.visible = out.visible && s.mean.x + x >= v.left + 0.5f && s.mean.x - x <= v.right - 0.5f &&
                s.mean.y + y >= v.top + 0.5f && s.mean.y - y <= v.bottom - 0.5f;
  return out;
}

/// Unit direction from the camera towards `mean`. The largest component is scaled to 1 first, so that no
/// square leaves the range of float.
SWIFTGS_HD inline vec3 view_direction(const ViewConstants& v, vec3 mean) {
  vec3 d(float(mean.x - v.centre[0]), float(mean.y - v.centre[1]), float(mean.z - v.centre[2]));
  const float largest = std::fmax(std::fmax(std::fabs(d.x), std::fabs(d.y)), std::fabs(d.z));
  for (int k = 0; k < 3; ++k) d[k] /= largest;
  return d * (1 / std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z));
}

/// Colour of Gaussian `i` in this view, before it is cut below at 0.
SWIFTGS_HD inline vec3 project_colour(const ViewConstants& v, const SceneView& scene, std::size_t i) {
  return sh_colour(scene, i, view_direction(v, scene.means[i]));
}

}  // namespace swiftgs
