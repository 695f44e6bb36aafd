// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Depth along the ray: a splat's depth at each pixel, by the depth where its Gaussian is densest along the
/// pixel's ray, linearised as the splat itself is.

#include <cmath>
#include <cstddef>

#include <swiftgs/lens/point.hpp>
#include <swiftgs/math.hpp>
#include <swiftgs/project.hpp>
#include <swiftgs/raster/passes.hpp>
#include <swiftgs/view_constants.hpp>
#include <swiftgs/views.hpp>

namespace swiftgs {

/// The square at `place` of depths whose coefficients, or weighted sums of them, are `squares`.
SWIFTGS_HD inline float sum_of_squares(const float* squares, vec2 place) {
  const float linear = squares[1] * place.x + squares[2] * place.y;
  const float by_x = squares[3] * place.x + squares[4] * place.y, by_y = squares[5] * place.y;
  return squares[0] + (linear + (by_x * place.x + by_y * place.y));
}

/// How the image and depth move with a Gaussian's own unit sphere.
struct SphereSlopes {
  ImageAxes<double> image;
  dvec3 depth;
};

SWIFTGS_HD inline SphereSlopes sphere_slopes(const ViewConstants& v, const Gaussian& g) {
  const CameraPoint at(v, g.mean);
  const dvec3 p(at.p[0], at.p[1], at.p[2]);
  const auto image = [&] {
    if (v.through_lens) {
      const LensPoint seen = point_through(v.lens, v.limits, p);
      return ImageAxes<double>(v, LensSlopes{seen.du, seen.dv, v.fx, v.fy}, g.scale, g.rotation);
    }
    const double inverse_z = inverse(p.z);
    const Linearisation<double> by{v.clamped_x(p.x * inverse_z), v.clamped_y(p.y * inverse_z),
                                   v.fx * inverse_z, v.fy * inverse_z};
    return ImageAxes<double>(v, by, g.scale, g.rotation);
  };
  const dvec3 ahead =
      v.depth_is_distance ? p * (v.depth_scale / std::sqrt(dot(p, p))) : dvec3(0.0, 0.0, v.depth_scale);
  dvec3 in_world(0.0), depth;
  for (int row = 0; row < 3; ++row)
    for (int k = 0; k < 3; ++k) in_world[k] += ahead[row] * v.rotation[row][k];
  const LocalAxes<double> axes(g.rotation);
  for (int k = 0; k < 3; ++k) depth[k] = g.scale[k] * dot(in_world, axes.column[k]);
  return {image(), depth};
}

/// Whether sums of planes of depth, and of their squares, stay finite in an image of this size.
SWIFTGS_HD inline bool is_summed(double middle, double x, double y, double width, double height,
                                 float most_squared) {
  const double most = std::fabs(middle) + std::fabs(x) * width + std::fabs(y) * height;
  return most * most <= double(most_squared);
}

/// The depth of a Gaussian that `view` shows at `mean`: the regression of depth on the place in the image, by
/// the covariance that is drawn. `depth` is its mean's. Where squares would exceed `most_squared`, the depth
/// does not vary.
SWIFTGS_HD inline RayDepth ray_depth(const ViewConstants& v, const Gaussian& g, vec2 mean, float depth,
                                     float most_squared) {
  const SphereSlopes by = sphere_slopes(v, g);
  const dvec3 &u = by.image.x, &w = by.image.y, across = cross(u, w);
  const double blur = v.blur, uu = dot(u, u), ww = dot(w, w);
  // Adjugate and determinant of the covariance as sums of squares and products (Binet-Cauchy): differences of
  // products would lose all digits of a needle.
  const double determinant = dot(across, across) + blur * (uu + ww + blur);
  const double x = (dot(across, cross(by.depth, w)) + blur * dot(u, by.depth)) / determinant;
  const double y = (dot(across, cross(u, by.depth)) + blur * dot(w, by.depth)) / determinant;
  const double right = mean.x - 0.5 * v.width, down = mean.y - 0.5 * v.height;
  const double middle = depth - (x * right + y * down);
  if (!is_summed(middle, x, y, v.width, v.height, most_squared)) return {depth, 0, 0};
  return {float(middle), float(x), float(y)};
}

}  // namespace swiftgs
