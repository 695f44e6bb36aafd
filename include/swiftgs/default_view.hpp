// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <vector>

#include <swiftgs/camera.hpp>
#include <swiftgs/edit/rotation.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/scene.hpp>
#include <swiftgs/tools/scene_bounds.hpp>

namespace swiftgs {

/// A camera and the point that it turns around.
struct OrbitView {
  Camera camera;
  dvec3 target{0.0};   ///< in the world
  dvec3 up{0, -1, 0};  ///< of any length; y points down in the world of most captures
};

namespace detail {
/// `v` turned about the unit vector `axis`.
inline dvec3 turned(const dvec3& v, const dvec3& axis, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return c * v + s * cross(axis, v) + (1 - c) * dot(axis, v) * axis;
}
}  // namespace detail

/// The camera of `view` moved around its target: to its right by `turn` about the axis `up`, by `rise`
/// towards `up`, never within a degree of the axis, and to `distance` times its distance. The target stays
/// where it is in the image, and things at its depth show at 1 / `distance` times their size, for which
/// the focal lengths of an orthographic camera change. Angles are in radians. Throws `InvalidArgument`
/// for an `up` of no length, a distance that is not above 0, and angles that are not finite.
inline Camera orbit(const OrbitView& view, double turn, double rise = 0, double distance = 1) {
  using detail::cross, detail::dot, detail::turned;
  const double length = std::sqrt(dot(view.up, view.up));
  if (!(length > 0 && detail::is_finite(length)))
    throw InvalidArgument("orbit: expected an up of a finite length above 0");
  if (!(distance > 0 && detail::is_finite(distance) && detail::is_finite(turn) && detail::is_finite(rise)))
    throw InvalidArgument("orbit: expected finite angles and a finite distance above 0");
  const dvec3 up = view.up / length;
  Camera camera = view.camera;
  const dvec3 seen = camera.rotation * view.target + camera.translation;  // which stays
  const dvec3 offset = camera.centre() - view.target;
  dvec3 right = cross(up, offset);
  const double level = std::sqrt(dot(right, right));
  if (level > 0) {
    constexpr double least = std::numbers::pi / 180;
    const double above = std::atan2(level, dot(up, offset));  // angle to the axis
    right /= level;
    rise =
        above - std::clamp(above - rise, std::min(above, least), std::max(above, std::numbers::pi - least));
  } else {
    rise = 0;
  }
  for (int row = 0; row < 3; ++row) {
    const dvec3 axis(camera.rotation[0][row], camera.rotation[1][row], camera.rotation[2][row]);
    const dvec3 moved = turned(turned(axis, right, -rise), up, turn);
    for (int column = 0; column < 3; ++column) camera.rotation[column][row] = moved[column];
  }
  camera.translation = distance * seen - camera.rotation * view.target;
  if (traits_of(camera.lens.model).parallel_rays) camera.fx /= distance, camera.fy /= distance;
  return camera;
}

namespace detail {

/// A small image of depths that `camera` sees, in which every point is a square of its size and brightness.
class DepthGrid {
 public:
  static constexpr int columns = 48, rows = 27;

  DepthGrid(const std::vector<SampledGaussian>& points, const Camera& camera, double distance) {
    for (const SampledGaussian& point : points) {
      const dvec3 p = camera.rotation * point.mean + camera.translation;
      if (p.z <= 0.02 * distance) continue;
      const double x = (camera.fx * p.x / p.z + camera.cx) * columns / camera.width;
      const double y = (camera.fy * p.y / p.z + camera.cy) * rows / camera.height;
      if (!(x >= 0 && x < columns && y >= 0 && y < rows)) continue;
      const int radius = int(std::min(8.0, camera.fx * point.size / p.z * columns / camera.width));
      for (int r = std::max(0, int(y) - radius); r <= std::min(rows - 1, int(y) + radius); ++r)
        for (int c = std::max(0, int(x) - radius); c <= std::min(columns - 1, int(x) + radius); ++c)
          if (Cell& cell = cells_[std::size_t(r * columns + c)]; p.z < cell.depth)
            cell = {p.z, point.brightness};
      inside_.push_back({std::size_t(int(y) * columns + int(x)), p.z});
    }
  }

  struct Cell {
    double depth = std::numeric_limits<double>::infinity(), brightness = 0;
  };
  const Cell& at(int column, int row) const { return cells_[std::size_t(row * columns + column)]; }

  /// Points that nothing hides.
  std::size_t visible() const {
    return std::size_t(std::count_if(inside_.begin(), inside_.end(), [&](const Inside& point) {
      return point.depth <= 1.15 * cells_[point.cell].depth;
    }));
  }

 private:
  struct Inside {
    std::size_t cell;
    double depth;
  };
  std::array<Cell, columns * rows> cells_;
  std::vector<Inside> inside_;
};

/// Rates the view of `camera`, which looks at a point at `distance`. A good view sees many points and covers
/// most of the image. Nothing stands in its way, and the top shows far or bright points.
inline double score_of(const std::vector<SampledGaussian>& points, const Camera& camera, double distance) {
  const DepthGrid grid(points, camera, distance);
  double covered = 0, blocked = 0, sky_at_top = 0;
  for (int row = 0; row < DepthGrid::rows; ++row)
    for (int column = 0; column < DepthGrid::columns; ++column) {
      const auto [depth, brightness] = grid.at(column, row);
      covered += std::isfinite(depth);
      blocked += depth < 0.4 * distance;
      const double relative = std::log2(std::clamp(depth / distance, 0.25, 4.0));
      sky_at_top += (row < DepthGrid::rows / 2 ? 1 : -1) * (relative + 2 * brightness);
    }
  const double cells = DepthGrid::columns * DepthGrid::rows;
  return 2 * double(grid.visible()) / double(std::max<std::size_t>(1, points.size())) +
         (covered - 2 * blocked + sky_at_top) / cells;
}

/// The direction in which the bulk is thinnest: across the ground, where most of a scene is ground.
inline dvec3 thinnest_direction(const std::vector<SampledGaussian>& points, const SceneBounds& bulk) {
  dmat3 covariance(0.0);
  for (const SampledGaussian& point : points) {
    const dvec3 d = (point.mean - bulk.centre) / bulk.radius;
    if (dot(d, d) >= 1) continue;
    for (int axis = 0; axis < 3; ++axis) covariance[axis] += d[axis] * d;
  }
  return principal_axes(covariance).directions[2];
}

/// Unit vectors that may point up: `up` if it is given, otherwise four axes. Worlds are seldom level, so an
/// axis near the ground's normal follows the ground.
inline std::vector<dvec3> axes_to_try(const std::vector<SampledGaussian>& points, const SceneBounds& bulk,
                                      const dvec3& up) {
  if (const double length = std::sqrt(dot(up, up)); length > 0) return {up / length};
  const dvec3 thin = points.empty() ? dvec3(0, 1, 0) : thinnest_direction(points, bulk);
  std::vector<dvec3> axes{dvec3(0, -1, 0), dvec3(0, 1, 0), dvec3(0, 0, 1), dvec3(0, 0, -1)};
  for (dvec3& axis : axes)
    if (const double along = dot(thin, axis); std::abs(along) > 0.7) axis = thin * (along > 0 ? 1.0 : -1.0);
  return axes;
}

/// The direction at right angles to `up` (unit) that `angle` chooses.
inline dvec3 level_direction(const dvec3& up, double angle) {
  const dvec3 other = std::abs(up.x) < 0.9 ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
  const dvec3 flat = other - dot(up, other) * up, x = flat / std::sqrt(dot(flat, flat));
  return x * std::cos(angle) + cross(up, x) * std::sin(angle);
}

}  // namespace detail

/// Where to start to look at a scene that comes without cameras: at the middle of the bulk of the Gaussians,
/// from where most of them are seen and none stands in the way. The shorter side of the image shows 0.8
/// radians. Coordinates are those of the means: relative to the scene's origin.
///
/// `up` is where up is in the scene's world, of any length. Where it is 0 it is guessed: -y, as in most
/// captures, unless y, z or -z puts much more that is far or bright at the top of the image, tilted to the
/// ground where one is found. Guesses may be wrong.
///
/// Throws `InvalidArgument` for an image with no pixels or too long a side.
inline OrbitView default_view(const Scene& scene, int width = 1280, int height = 720,
                              const dvec3& up = dvec3(0)) {
  if (std::min(width, height) < 1 || std::max(width, height) > max_image_side)
    detail::refuse("default_view: the image is ", width, " x ", height,
                   ", expected 1 to 65536 pixels a side");
  constexpr double shorter_fov = 0.8;
  const std::vector<detail::SampledGaussian> points = detail::sample_gaussians(scene);
  const SceneBounds bulk = detail::bounds_of(points);
  dvec3 best_offset{0}, best_up{0};
  double best_score = -std::numeric_limits<double>::infinity();
  for (const dvec3& axis : detail::axes_to_try(points, bulk, up))
    for (const double away : {1.0, 1.5, 2.2})
      for (int k = 0; k < 16; ++k) {
        const dvec3 side = detail::level_direction(axis, 6.283185307179586 * k / 16);
        const dvec3 offset = (side * 0.92 + axis * 0.39) * (away * bulk.radius);
        const Camera camera = look_at(bulk.centre + offset, bulk.centre, axis, shorter_fov, 1280, 720);
        // Distance shows more and has a price. Most worlds have y down.
        const double value =
            detail::score_of(points, camera, away * bulk.radius) - 0.6 * away - (axis.y < -0.7 ? 0 : 0.3);
        if (value > best_score) best_offset = offset, best_up = axis, best_score = value;
      }
  const double taller = std::max(1.0, double(height) / width);
  const double vertical_fov = 2 * std::atan(std::tan(0.5 * shorter_fov) * taller);
  return {look_at(bulk.centre + best_offset, bulk.centre, best_up, vertical_fov, width, height), bulk.centre,
          best_up};
}

}  // namespace swiftgs
