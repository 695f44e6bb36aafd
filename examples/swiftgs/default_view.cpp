// SPDX-License-Identifier: Apache-2.0
#include "default_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace swiftgs::cli {
namespace {

constexpr int image_width = 1280, image_height = 720;
constexpr double vertical_fov = 0.8;

double length(const dvec3& v) { return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z); }

/// The value that `part` of `values` are below.
double quantile(std::vector<double> values, double part) {
  const auto at = values.begin() + std::ptrdiff_t(part * double(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Means of solid Gaussians, or of all where none is; at most about 40,000, evenly chosen.
std::vector<dvec3> sample(const Scene& scene) {
  constexpr std::size_t enough = 40'000;
  std::vector<dvec3> solid, any;
  const std::size_t step = std::max<std::size_t>(1, scene.size() / enough);
  for (std::size_t i = 0; i < scene.size(); i += step) {
    any.emplace_back(scene.means[i]);
    if (scene.opacities[i] > 0.3f) solid.emplace_back(scene.means[i]);
  }
  return solid.empty() ? any : solid;
}

/// How good a view `camera` is. Means are drawn as points into a coarse grid of depths.
double score(const std::vector<dvec3>& points, const Camera& camera, double distance) {
  constexpr int columns = 32, rows = 18;
  constexpr double nothing = std::numeric_limits<double>::infinity();
  std::array<double, columns * rows> nearest;
  nearest.fill(nothing);
  for (const dvec3& point : points) {
    const dvec3 p = camera.rotation * point + camera.translation;
    if (p.z <= 0.02 * distance) continue;
    const double x = (camera.fx * p.x / p.z + camera.cx) * columns / camera.width;
    const double y = (camera.fy * p.y / p.z + camera.cy) * rows / camera.height;
    if (!(x >= 0 && x < columns && y >= 0 && y < rows)) continue;
    double& cell = nearest[std::size_t(int(y) * columns + int(x))];
    cell = std::min(cell, p.z);
  }
  double covered = 0, blocked = 0, far_at_top = 0;
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) {
      const double depth = nearest[std::size_t(y * columns + x)];
      covered += depth < nothing;
      blocked += depth < 0.4 * distance;
      const double relative = std::log2(std::clamp(depth / distance, 0.25, 4.0));
      far_at_top += y < rows / 2 ? relative : -relative;
    }
  const double cells = columns * rows;
  return (covered - 2 * blocked + 0.5 * far_at_top) / cells;
}

}  // namespace

Camera default_view(const Scene& scene) {
  const std::vector<dvec3> points = sample(scene);
  dvec3 centre(0.0);
  double radius = 1;
  if (!points.empty()) {
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<double> values;
      for (const dvec3& p : points) values.push_back(p[axis]);
      centre[axis] = quantile(std::move(values), 0.5);
    }
    std::vector<double> distances;
    for (const dvec3& p : points) distances.push_back(length(p - centre));
    radius = std::max(quantile(std::move(distances), 0.5), 1e-6);
  }

  Camera best;
  double best_score = -std::numeric_limits<double>::infinity();
  const dvec3 ups[] = {{0, -1, 0}, {0, 1, 0}, {0, 0, 1}};
  for (const dvec3& up : ups)
    for (const double away : {1.0, 1.6, 2.4})
      for (int k = 0; k < 16; ++k) {
        const double angle = 6.283185307179586 * k / 16, across = std::cos(angle), along = std::sin(angle);
        const dvec3 level = up.z != 0 ? dvec3(across, along, 0) : dvec3(across, 0, along);
        const double distance = away * radius;
        const Camera camera = look_at(centre + (level * 0.92 + up * 0.39) * distance, centre, up,
                                      vertical_fov, image_width, image_height);
        // Far from the scene more of it is covered, so distance has a price. Most worlds have y down.
        const double value = score(points, camera, distance) - 0.15 * away - (up.y < 0 ? 0 : 0.1);
        if (value > best_score) best = camera, best_score = value;
      }
  best.name = "view";
  return best;
}

}  // namespace swiftgs::cli
