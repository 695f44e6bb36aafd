// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A second oracle, for the first: every pixel against every Gaussian, in long double, by the textbook's
/// formulae (covariance, its inverse, the quadratic form) and with no bound but the convention's.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <swiftgs/camera.hpp>
#include <swiftgs/conventions.hpp>
#include <swiftgs/scene.hpp>

namespace swiftgs::test {

using Real = long double;

struct BruteSplat {
  Real x, y, z, xx, xy, yy, det, opacity;
  std::array<Real, 3> colour;
  int x_begin, x_end, y_begin, y_end;  ///< what the convention's footprint leaves
};

struct BruteFrame {
  std::vector<double> colour, alpha, depth;
  std::uint64_t visible = 0, contributing_pairs = 0, pixels_stopped = 0;
};

/// Tiles that INRIA's square selects, with the conversions to int of its formula.
inline void brute_square(BruteSplat& s, const Camera& camera) {
  const Real mid = (s.xx + s.yy) / 2;
  const Real lambda = mid + std::sqrt(std::max(Real(0.1), mid * mid - s.det));
  const Real radius = std::ceil(3 * std::sqrt(lambda)), x = s.x - 0.5L, y = s.y - 0.5L;
  const int columns = (camera.width + 15) / 16, rows = (camera.height + 15) / 16;
  const auto tile = [](Real value, int count) { return std::min(count, std::max(0, int(value / 16))); };
  s.x_begin = 16 * tile(x - radius, columns), s.x_end = 16 * tile(x + radius + 15, columns);
  s.y_begin = 16 * tile(y - radius, rows), s.y_end = 16 * tile(y + radius + 15, rows);
}

/// Projects Gaussian `i` of a scene of degree 0; false when it is culled.
inline bool brute_project(const Scene& scene, std::size_t i, const Camera& camera, const Conventions& k,
                          BruteSplat& s) {
  const vec3 m = scene.means[i], scale = scene.scales[i];
  const Quaternion q = scene.rotations[i];
  const Real w = q.w, a = q.x, b = q.y, c = q.z;
  const Real axes[3][3] = {{1 - 2 * (b * b + c * c), 2 * (a * b - w * c), 2 * (a * c + w * b)},
                           {2 * (a * b + w * c), 1 - 2 * (a * a + c * c), 2 * (b * c - w * a)},
                           {2 * (a * c - w * b), 2 * (b * c + w * a), 1 - 2 * (a * a + b * b)}};
  Real p[3], turned[3][3] = {};
  for (int r = 0; r < 3; ++r) {
    p[r] = camera.translation[r];
    for (int j = 0; j < 3; ++j) {
      p[r] += Real(camera.rotation[j][r]) * m[j];
      for (int l = 0; l < 3; ++l) turned[r][j] += Real(camera.rotation[l][r]) * axes[l][j] * scale[j];
    }
  }
  if (p[2] < k.near_plane || (k.cull_at_near && p[2] == k.near_plane) || p[2] > k.far_plane) return false;

  const bool image = k.clamp == Conventions::JacobianClamp::around_image;
  const auto limited = [&](Real t, Real size, Real focal, Real centre) {
    const Real tangent = size / (2 * focal);
    const Real low = image ? -(centre / focal + 0.3L * tangent) : -1.3L * tangent;
    const Real high = image ? (size - centre) / focal + 0.3L * tangent : 1.3L * tangent;
    return std::min(high, std::max(low, t));
  };
  const Real tx = limited(p[0] / p[2], camera.width, camera.fx, camera.cx);
  const Real ty = limited(p[1] / p[2], camera.height, camera.fy, camera.cy);
  Real xx = 0, xy = 0, yy = 0;
  for (int j = 0; j < 3; ++j) {
    const Real u = camera.fx / p[2] * (turned[0][j] - tx * turned[2][j]);
    const Real v = camera.fy / p[2] * (turned[1][j] - ty * turned[2][j]);
    xx += u * u, xy += u * v, yy += v * v;
  }
  s = {.x = camera.fx * p[0] / p[2] + camera.cx,
       .y = camera.fy * p[1] / p[2] + camera.cy,
       .z = p[2],
       .xx = xx + k.blur,
       .xy = xy,
       .yy = yy + k.blur,
       .det = (xx + k.blur) * (yy + k.blur) - xy * xy,
       .opacity = scene.opacities[i],
       .colour = {},
       .x_begin = 0,
       .x_end = camera.width,
       .y_begin = 0,
       .y_end = camera.height};
  if (s.det <= 0) return false;
  if (k.antialiased) s.opacity *= std::sqrt(std::max(Real(k.min_compensation), (xx * yy - xy * xy) / s.det));
  for (int c3 = 0; c3 < 3; ++c3)
    s.colour[std::size_t(c3)] = std::max(Real(0), 0.5L + 0.28209479177387814L * scene.sh0[i][c3]);
  if (k.footprint == Conventions::Footprint::three_sigma_square) brute_square(s, camera);
  return true;
}

/// Renders a scene of degree 0 on black.
inline BruteFrame render_brute_force(const Scene& scene, const Camera& camera, const Conventions& k) {
  std::vector<BruteSplat> splats;
  BruteSplat splat;
  for (std::size_t i = 0; i < scene.size(); ++i)
    if (brute_project(scene, i, camera, k, splat)) splats.push_back(splat);
  std::stable_sort(splats.begin(), splats.end(),
                   [](const BruteSplat& a, const BruteSplat& b) { return float(a.z) < float(b.z); });

  BruteFrame frame;
  std::vector<bool> seen(splats.size());
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      Real T = 1, colour[3] = {}, depth = 0, weights = 0;
      for (std::size_t n = 0; n < splats.size(); ++n) {
        const BruteSplat& s = splats[n];
        if (x < s.x_begin || x >= s.x_end || y < s.y_begin || y >= s.y_end) continue;
        const Real dx = x + 0.5L - s.x, dy = y + 0.5L - s.y;
        const Real sigma = (s.yy * dx * dx - 2 * s.xy * dx * dy + s.xx * dy * dy) / (2 * s.det);
        if (sigma < 0) continue;
        const Real alpha = std::min(Real(k.alpha_max), s.opacity * std::exp(-sigma));
        if (alpha < k.alpha_min) continue;
        const Real next = T * (1 - alpha);
        if (k.stop_at_equal ? next <= k.stop : next < k.stop) {
          ++frame.pixels_stopped;
          break;
        }
        for (int c = 0; c < 3; ++c) colour[c] += alpha * T * s.colour[std::size_t(c)];
        depth += alpha * T * s.z, weights += alpha * T, T = next;
        ++frame.contributing_pairs, seen[n] = true;
      }
      for (const Real channel : colour) frame.colour.push_back(double(channel));
      frame.alpha.push_back(double(1 - T));
      frame.depth.push_back(weights > 0 ? double(depth / weights) : 0);
    }
  frame.visible = std::uint64_t(std::count(seen.begin(), seen.end(), true));
  return frame;
}

}  // namespace swiftgs::test
