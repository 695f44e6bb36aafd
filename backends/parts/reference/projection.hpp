// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include <swiftgs/camera.hpp>
#include <swiftgs/conventions.hpp>
#include <swiftgs/frame/splats.hpp>
#include <swiftgs/plane/attributes.hpp>
#include <swiftgs/reference.hpp>
#include <swiftgs/scene.hpp>

#include "colour.hpp"
#include "lens.hpp"

namespace swiftgs::reference {

/// Covariance in the image.
struct Covariance {
  double xx = 0, xy = 0, yy = 0;  ///< with blur @units{pixels^2}
  double det = 0;                 ///< with blur
  double det_sharp = 0;           ///< without blur
};

/// A projected Gaussian. Its exponent is kept as a sum of two squares,
///   2 sigma = x_weight (dx - shear dy)^2 + y_weight dy^2,
/// because the textbook form A dx^2 + 2 B dx dy + C dy^2 loses up to 12 of double's 16 digits on a needle
/// that is a million pixels long; and a sum of squares is never negative.
struct Splat {
  double x = 0, y = 0;  ///< mean in the image @units{pixels}
  double x_weight = 0, y_weight = 0, shear = 0;
  double opacity = 0;  ///< with the anti-aliasing factor
  double cutoff = 0;   ///< at 2 sigma above this, alpha is below `alpha_min` whatever the rounding
  double depth = 0;    ///< of the mean, as `Conventions::depth` has it
  double order = 0;    ///< what splats are sorted by
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();   ///< of depth along the ray @units{depth per pixel}
  Eigen::Vector3d colour = Eigen::Vector3d::Zero();  ///< RGB, the scene's own values
  Covariance covariance;
  std::size_t index = 0;                               ///< number of the Gaussian in the frame
  int x_begin = 0, x_end = 0, y_begin = 0, y_end = 0;  ///< no pixel outside is reached

  /// At pixel (column, row), as `Conventions::depth_at` has it.
  double depth_at(int column, int row) const {
    return depth + slope.dot(Eigen::Vector2d(column + 0.5 - x, row + 0.5 - y));
  }
};

/// Columns of the image, and the one whose nearest copy of a splat they show. @units{pixels}
struct Columns {
  int begin, end;
  double middle;
};

/// What all Gaussians of a placed scene are projected with. A point p of the scene is at
/// scale * rotation p + translation of camera space, which has the world's lengths.
struct View {
  View(const Camera& c, const Conventions& k, const ReferenceScene& scene, std::size_t first_index = 0)
      : camera(c),
        conventions(as_trained(k, scene.scene.model)),
        placed(scene),
        first(first_index),
        lens(c, k) {
    const Similarity& pose = placed.world_from_scene;
    Eigen::Matrix3d of_camera, of_scene;
    Eigen::Vector3d camera_at, scene_at;
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        of_camera(row, column) = c.rotation[column][row];
        of_scene(row, column) = pose.rotation[column][row];
      }
      camera_at[row] = c.translation[row], scene_at[row] = pose.translation[row];
    }
    scale = pose.scale;
    rotation = of_camera * of_scene;
    translation = of_camera * scene_at + camera_at;
    centre = -rotation.inverse() * translation / scale;
    const int width = panorama_part(c) > 0 ? panorama_part(c) : c.width;
    for (int x = 0; x < c.width; x += width)
      parts.push_back(
          {x, std::min(c.width, x + width), panorama_part(c) > 0 ? x + 0.5 * width : 0.5 * c.width});
  }

  Camera camera;
  Conventions conventions;
  ReferenceScene placed;
  std::size_t first;  ///< number of the scene's first Gaussian
  CameraLens lens;
  double scale;
  Eigen::Matrix3d rotation;  ///< from the scene to the camera
  Eigen::Vector3d translation;
  Eigen::Vector3d centre;      ///< of the camera, in the scene
  std::vector<Columns> parts;  ///< of the image, each with a copy of every splat that it shows
};

/// How camera space moves with the unit sphere of Gaussian `i`.
inline Eigen::Matrix3d gaussian_axes(const Scene& scene, std::size_t i, const View& view) {
  // The rotation as it is stored, not normalised again: float's rounding of it is part of the scene.
  const Quaternion& q = scene.rotations[i];
  const Eigen::Matrix3d axes = Eigen::Quaterniond(q.w, q.x, q.y, q.z).toRotationMatrix();
  const vec3& s = scene.scales[i];
  return view.scale * view.rotation * axes * Eigen::Vector3d(s.x, s.y, s.z).asDiagonal();
}

/// Projects the covariance of Gaussian `i`, which a lens shows with this Jacobian.
inline Covariance project_covariance(const Scene& scene, std::size_t i,
                                     const Eigen::Matrix<double, 2, 3>& jacobian, const View& view) {
  const Eigen::Matrix<double, 2, 3> factor = jacobian * gaussian_axes(scene, i, view);

  // The determinant of F F^T is |row 0 x row 1|^2 (Cauchy-Binet): no difference of products of large numbers.
  const Eigen::Vector3d row_x = factor.row(0), row_y = factor.row(1);
  const double blur = *view.conventions.blur, xx = row_x.squaredNorm(), yy = row_y.squaredNorm();
  const double det_sharp = row_x.cross(row_y).squaredNorm();
  return {.xx = xx + blur,
          .xy = row_x.dot(row_y),
          .yy = yy + blur,
          .det = det_sharp + blur * (xx + yy) + blur * blur,
          .det_sharp = det_sharp};
}

/// Slope over the image of the depth along the ray of Gaussian `i`, with splat `splat` and mean `p`. It is
/// the slope of the plane that fits depths on the Gaussian best, in least squares with the blur as noise of
/// the image. Zero where renderers could not sum squares of depths.
inline Eigen::Vector2d slope_of_depth(const Splat& splat, const Scene& scene, std::size_t i,
                                      const Eigen::Vector3d& p, const Eigen::Matrix<double, 2, 3>& jacobian,
                                      const View& view) {
  const Eigen::Matrix3d axes = gaussian_axes(scene, i, view);
  Eigen::Matrix<double, 5, 2> places = Eigen::Matrix<double, 5, 2>::Zero();
  places.topRows<3>() = (jacobian * axes).transpose();
  places.bottomRows<2>().diagonal().setConstant(std::sqrt(double(*view.conventions.blur)));
  Eigen::Matrix<double, 5, 1> depths = Eigen::Matrix<double, 5, 1>::Zero();
  const Eigen::Vector3d ahead = view.lens.by_distance() ? p.stableNormalized() : Eigen::Vector3d(0, 0, 1);
  depths.head<3>() = axes.transpose() * ahead;
  // By the columns made orthogonal, the right side last.
  const double across = places.col(0).norm();
  const Eigen::Matrix<double, 5, 1> first = places.col(0) / across;
  const double shared = first.dot(places.col(1));
  const Eigen::Matrix<double, 5, 1> rest = places.col(1) - shared * first;
  const double down = rest.norm(), along_first = first.dot(depths);
  const double second = rest.dot(depths - along_first * first) / (down * down);
  const Eigen::Vector2d slope((along_first - shared * second) / across, second);

  const double width = view.camera.width, height = view.camera.height;
  const double middle = splat.depth + slope.dot(Eigen::Vector2d(width / 2 - splat.x, height / 2 - splat.y));
  const double most = std::abs(middle) + std::abs(slope.x()) * width + std::abs(slope.y()) * height;
  const bool summed = most * most <= double(most_attribute(view.conventions.alpha_max));
  return summed ? slope : Eigen::Vector2d::Zero();
}

/// The whole numbers in [low, high], as a half-open range inside [0, size).
inline void set_range(double low, double high, int size, int& begin, int& end) {
  begin = int(std::clamp(std::ceil(low), 0.0, double(size)));
  end = int(std::clamp(std::floor(high) + 1, double(begin), double(size)));
}

/// Sets the rectangle outside which alpha is surely below `alpha_min`: the bounding box of the ellipse at
/// `cutoff`, widened by far more than rounding can move it.
inline void bound_by_alpha(Splat& splat, const View& view, Columns part) {
  const auto half = [&](double variance) { return std::sqrt(splat.cutoff * variance) * (1 + 1e-9) + 1; };
  const double half_x = half(splat.covariance.xx), half_y = half(splat.covariance.yy);
  set_range(splat.x - 0.5 - half_x, splat.x - 0.5 + half_x, view.camera.width, splat.x_begin, splat.x_end);
  splat.x_begin = std::max(splat.x_begin, part.begin), splat.x_end = std::min(splat.x_end, part.end);
  set_range(splat.y - 0.5 - half_y, splat.y - 0.5 + half_y, view.camera.height, splat.y_begin, splat.y_end);
}

/// Squared Mahalanobis distance at which `Conventions::Footprint::three_sigma_ellipse` cuts a splat.
inline constexpr double three_sigmas_squared = 9;

/// Three standard deviations along the larger axis, as INRIA's square has them.
inline double three_sigmas(const Covariance& cov) {
  const double mid = 0.5 * (cov.xx + cov.yy), difference = 0.5 * (cov.xx - cov.yy);
  return 3 * std::sqrt(mid + std::sqrt(std::max(0.1, difference * difference + cov.xy * cov.xy)));
}

/// First pixel, and the one behind the last, of the 16x16 tiles that INRIA's square selects along an axis.
/// The square is placed in coordinates where pixel centres are whole numbers, and its end is rounded as if it
/// were 15 pixels further.
struct SquareSide {
  double first, last;

  SquareSide(double mean, double three_sigmas) {
    constexpr double tile = 16;
    const double p = mean - 0.5, radius = std::ceil(three_sigmas);
    first = tile * std::max(0.0, std::floor((p - radius) / tile));
    last = tile * std::max(0.0, std::floor((p + radius + tile - 1) / tile));
  }
};

/// Cuts the rectangle to the tiles of INRIA's square of three standard deviations.
inline void cut_to_three_sigma_square(Splat& splat) {
  const double sigmas = three_sigmas(splat.covariance);
  const auto cut = [&](double mean, int& begin, int& end) {
    const SquareSide side(mean, sigmas);
    begin = int(std::max(double(begin), std::min(side.first, double(end))));
    end = int(std::max(double(begin), std::min(side.last, double(end))));
  };
  cut(splat.x, splat.x_begin, splat.x_end);
  cut(splat.y, splat.y_begin, splat.y_end);
}

/// Whether a Gaussian of camera-space depth `depth` is drawn. Depth is a float, to the planes as to the
/// order.
inline bool is_between_planes(float depth, const Conventions& k) {
  const float near_plane = std::max(k.near_plane, least_depth);
  const bool near_enough = k.cull_at_near ? depth > near_plane : depth >= near_plane;
  return near_enough && depth <= k.far_plane && std::isfinite(depth);
}

/// Mean of Gaussian `i` in camera space.
inline Eigen::Vector3d camera_space_mean(const Scene& scene, std::size_t i, const View& view) {
  const vec3& m = scene.means[i];
  return view.scale * (view.rotation * Eigen::Vector3d(m.x, m.y, m.z)) + view.translation;
}

/// Whether the clip of a placed scene shows a Gaussian with this mean.
inline bool is_shown(const Clip& clip, const vec3& mean) {
  const Eigen::Vector3d m(mean.x, mean.y, mean.z);
  for (int i = 0; i < clip.half_space_count; ++i) {
    const vec4& h = clip.half_spaces[i];
    if (!(Eigen::Vector3d(h.x, h.y, h.z).dot(m) + h.w >= 0)) return false;
  }
  const vec3& c = clip.centre;
  return clip.radius == std::numeric_limits<float>::infinity() ||
         (m - Eigen::Vector3d(c.x, c.y, c.z)).squaredNorm() <= double(clip.radius) * clip.radius;
}

/// Projects Gaussian `i`, whose mean is at `p` in camera space, without its colour. Does not test planes,
/// opacity or image. Returns nothing if its numbers or its splat's are not finite, or too large.
inline std::optional<Splat> project_unculled(const Scene& scene, std::size_t i, const Eigen::Vector3d& p,
                                             const View& view, Columns part) {
  const Conventions& k = view.conventions;
  const std::optional<SeenPoint> seen = view.lens.point(p, part.middle);
  if (!seen) return {};
  const Covariance cov = project_covariance(scene, i, seen->jacobian, view);
  if (!(cov.det > 0) || !std::isfinite(cov.det)) return {};
  if (!(cov.xx <= double(largest_variance) && cov.yy <= double(largest_variance))) return {};

  Splat splat;
  splat.opacity = double(scene.opacities[i]) * view.placed.opacity;
  if (*k.antialiased)
    splat.opacity *= std::sqrt(std::max(double(k.min_compensation), cov.det_sharp / cov.det));
  splat.cutoff = k.alpha_min > 0 ? 2 * std::log(splat.opacity / double(k.alpha_min)) * (1 + 1e-9) + 1e-9
                                 : std::numeric_limits<double>::infinity();
  splat.x = seen->x, splat.y = seen->y;
  splat.x_weight = cov.yy / cov.det;
  splat.y_weight = 1 / cov.yy;
  splat.shear = cov.xy / cov.yy;
  splat.depth = view.lens.depth(p);
  splat.order = *k.order == SplatOrder::distance ? p.stableNorm() : splat.depth;
  splat.index = view.first + i;
  splat.covariance = cov;
  if (k.depth_at == Conventions::DepthAt::ray)
    splat.slope = slope_of_depth(splat, scene, i, p, seen->jacobian, view);
  const double sum =
      splat.x + splat.y + splat.x_weight + splat.y_weight + splat.shear + splat.depth + splat.opacity;
  if (!std::isfinite(sum)) return {};
  return splat;
}

/// Evaluates the colour of Gaussian `i`, whose splat is `splat`; false where a channel is not a finite float,
/// and the splat is not drawn.
inline bool shade(Splat& splat, const Scene& scene, std::size_t i, const View& view) {
  const vec3& m = scene.means[i];
  const Eigen::Vector3d direction = Eigen::Vector3d(m.x, m.y, m.z) - view.centre;
  const Eigen::Vector3d sum = colour(scene, i, direction.stableNormalized());
  const Tint& tint = view.placed.tint;
  const double amount = tint.amount;
  for (int c = 0; c < 3; ++c)
    splat.colour[c] = (1 - amount) * std::max(sum[c], 0.0) + amount * double(tint.colour[c]);
  return sum.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() <= double(std::numeric_limits<float>::max());
}

/// Projects Gaussian `i` of the view's scene for a part of the image; nothing when it is culled or reaches no
/// pixel there.
inline std::optional<Splat> project(std::size_t i, const View& view, Columns part) {
  const Conventions& k = view.conventions;
  const Scene& scene = view.placed.scene;
  if (!is_shown(view.placed.clip, scene.means[i])) return {};
  const Eigen::Vector3d p = camera_space_mean(scene, i, view);
  if (!is_between_planes(float(view.lens.depth(p)), k)) return {};
  std::optional<Splat> splat = project_unculled(scene, i, p, view, part);
  if (!splat || !(splat->opacity >= double(k.alpha_min))) return {};
  bound_by_alpha(*splat, view, part);
  if (k.footprint == Conventions::Footprint::three_sigma_square) cut_to_three_sigma_square(*splat);
  if (splat->x_begin >= splat->x_end || splat->y_begin >= splat->y_end) return {};
  if (!shade(*splat, scene, i, view)) return {};
  return splat;
}

}  // namespace swiftgs::reference
