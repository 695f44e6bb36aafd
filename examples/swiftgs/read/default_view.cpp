// SPDX-License-Identifier: Apache-2.0
#include "read/default_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Eigenvalues>

namespace swiftgs::cli {
namespace {

constexpr int image_width = 1280, image_height = 720;
constexpr double vertical_fov = 0.8;

double length(const dvec3& v) { return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z); }

/// The direction at right angles to `up` (unit) that `angle` chooses.
dvec3 level(const dvec3& up, double angle) {
  const dvec3 other = std::abs(up.x) < 0.9 ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
  const dvec3 flat = other - up * (up.x * other.x + up.y * other.y + up.z * other.z);
  const dvec3 x = flat / length(flat),
              y(up.y * x.z - up.z * x.y, up.z * x.x - up.x * x.z, up.x * x.y - up.y * x.x);
  return x * std::cos(angle) + y * std::sin(angle);
}

/// The value that `part` of `values` are below.
double quantile(std::vector<double> values, double part) {
  const auto at = values.begin() + std::ptrdiff_t(part * double(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

struct Point {
  dvec3 mean;
  double size;        ///< longest standard deviation
  double brightness;  ///< 0 to 1
};

/// Solid Gaussians, or all where none is; at most about 20,000, evenly chosen.
std::vector<Point> sample(const Scene& scene) {
  constexpr std::size_t enough = 20'000;
  std::vector<Point> solid, any;
  const std::size_t step = std::max<std::size_t>(1, scene.size() / enough);
  for (std::size_t i = 0; i < scene.size(); i += step) {
    const vec3& s = scene.scales[i];
    const double colour = 0.5 + 0.28209479177387814 * (scene.sh0[i].x + scene.sh0[i].y + scene.sh0[i].z) / 3;
    any.push_back({dvec3(scene.means[i]), double(std::max({s.x, s.y, s.z})), std::clamp(colour, 0.0, 1.0)});
    if (scene.opacities[i] > 0.3f) solid.push_back(any.back());
  }
  return solid.empty() ? any : solid;
}

/// A small image of depths that `camera` sees, in which every point is a square of its size and brightness.
class DepthGrid {
 public:
  static constexpr int columns = 48, rows = 27;

  DepthGrid(const std::vector<Point>& points, const Camera& camera, double distance) {
    for (const Point& point : points) {
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

/// How good a view `camera` is, which looks at a point at `distance`: it sees many points, most of the image
/// is covered, nothing stands in the way, and what is far or bright is at the top.
double score(const std::vector<Point>& points, const Camera& camera, double distance) {
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

/// The middle of the points, and how far from it half of them are.
struct Bulk {
  dvec3 centre{0.0};
  double radius = 1;
};

Bulk bulk_of(const std::vector<Point>& points) {
  Bulk bulk;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const Point& p : points) values.push_back(p.mean[axis]);
    bulk.centre[axis] = quantile(std::move(values), 0.5);
  }
  std::vector<double> distances;
  for (const Point& p : points) distances.push_back(length(p.mean - bulk.centre));
  bulk.radius = std::max(quantile(std::move(distances), 0.5), 1e-6);
  return bulk;
}

/// The direction in which the bulk is thinnest: across the ground, where most of a scene is ground.
dvec3 thinnest_direction(const std::vector<Point>& points, const Bulk& bulk) {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Point& p : points) {
    const dvec3 d = p.mean - bulk.centre;
    const Eigen::Vector3d v(d.x, d.y, d.z);
    if (v.norm() < bulk.radius) covariance += v * v.transpose();
  }
  const Eigen::Vector3d axis =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvectors().col(0);
  return {axis.x(), axis.y(), axis.z()};
}

}  // namespace

dvec3 middle_of(const Scene& scene) {
  const std::vector<Point> points = sample(scene);
  return points.empty() ? dvec3(0.0) : bulk_of(points).centre;
}

Camera default_view(const Scene& scene) {
  const std::vector<Point> points = sample(scene);
  const Bulk bulk = points.empty() ? Bulk() : bulk_of(points);
  const dvec3 thin = points.empty() ? dvec3(0, 1, 0) : thinnest_direction(points, bulk);
  Camera best;
  double best_score = -std::numeric_limits<double>::infinity();
  for (const dvec3& axis : {dvec3(0, -1, 0), dvec3(0, 1, 0), dvec3(0, 0, 1), dvec3(0, 0, -1)}) {
    // Worlds are seldom level: follow the ground where it is near the axis.
    const double along = thin.x * axis.x + thin.y * axis.y + thin.z * axis.z;
    const dvec3 up = std::abs(along) > 0.7 ? thin * (along > 0 ? 1.0 : -1.0) : axis;
    for (const double away : {1.0, 1.5, 2.2})
      for (int k = 0; k < 16; ++k) {
        const double angle = 6.283185307179586 * k / 16;
        const dvec3 side = level(up, angle), offset = (side * 0.92 + up * 0.39) * (away * bulk.radius);
        const Camera camera =
            look_at(bulk.centre + offset, bulk.centre, up, vertical_fov, image_width, image_height);
        // Distance shows more and has a price. Most worlds have y down.
        const double value = score(points, camera, away * bulk.radius) - 0.6 * away - (axis.y < 0 ? 0 : 0.3);
        if (value > best_score) best = camera, best_score = value;
      }
  }
  best.name = "view";
  return best;
}

}  // namespace swiftgs::cli
