// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Chunks: Gaussians that are neighbours in the arrays of a scene. A view skips all of a chunk if it can show
/// none. That gains where neighbours in the arrays are neighbours in space, as `order_spatially` makes them.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/scene_view.hpp>
#include <swiftgs/frame/view_constants.hpp>
#include <swiftgs/lens/box.hpp>

namespace swiftgs {

namespace detail {
/// How much longer the matrix of a quaternion, unit or not, can make a vector: it is |q|^2 times that of the
/// unit quaternion, plus (1 - |q|^2) I.
SWIFTGS_HD inline double most_lengthened(Quaternion q) {
  const double squares = double(q.w) * q.w + double(q.x) * q.x + double(q.y) * q.y + double(q.z) * q.z;
  return squares + std::fabs(1 - squares);
}

/// Sum of the sides of the box around the means `first`, `first + step` and so on, `chunk_size` means at
/// most.
inline double sides_of_box(const SceneView& scene, std::size_t first, std::size_t step) {
  vec3 low = scene.means[first], high = low;
  for (std::size_t n = 0, i = first; n < chunk_size && i < scene.size(); ++n, i += step)
    low = glm::min(low, scene.means[i]), high = glm::max(high, scene.means[i]);
  const dvec3 sides = dvec3(high) - dvec3(low);
  return sides.x + sides.y + sides.z;
}

/// Widens `bounds` so that they hold `other` too.
SWIFTGS_HD inline void add_bounds(ChunkBounds& bounds, const ChunkBounds& other) {
  const auto larger = [](float a, float b) { return a < b ? b : a; };
  for (int k = 0; k < 3; ++k) {
    bounds.low[k] = -larger(-bounds.low[k], -other.low[k]);
    bounds.high[k] = larger(bounds.high[k], other.high[k]);
  }
  bounds.size = larger(bounds.size, other.size), bounds.opacity = larger(bounds.opacity, other.opacity);
}

/// Widens `bounds` to Gaussian `i`. A NaN widens nothing: its Gaussian is not drawn.
SWIFTGS_HD inline void add_gaussian(ChunkBounds& bounds, const SceneView& scene, std::size_t i) {
  const vec3 scale = scene.scales[i];  // its sign is squared away
  float largest = 0;
  for (int k = 0; k < 3; ++k) largest = std::fabs(scale[k]) > largest ? std::fabs(scale[k]) : largest;
  const double size = double(largest) * (scene.any_rotations ? 1 : most_lengthened(scene.rotations[i]));
  add_bounds(bounds,
             {scene.means[i], std::nextafter(float(size), INFINITY), scene.means[i], scene.opacities[i]});
}

inline ChunkBounds bounds_of_chunk(const SceneView& scene, std::size_t chunk) {
  ChunkBounds bounds;
  const std::size_t begin = chunk * chunk_size, end = std::min(begin + chunk_size, scene.size());
  for (std::size_t i = begin; i < end; ++i) add_gaussian(bounds, scene, i);
  return bounds;
}
}  // namespace detail

/// Bounds of all chunks of `scene`, which is in the host's memory and has finite numbers alone. @shape{ceil(N
/// / chunk_size)}. Empty if chunks are not worth their test: if boxes of neighbours are on average more than
/// half as large as boxes of random Gaussians, none counted as more than four times the median of the latter,
/// so that strays do not decide. Takes O(N).
inline std::vector<ChunkBounds> chunk_bounds(const SceneView& scene) {
  const std::size_t count = (scene.size() + chunk_size - 1) / chunk_size;
  if (count == 0) return {};
  std::vector<double> of_neighbours(count), of_any(count);
  for (std::size_t c = 0; c < count; ++c) {
    of_neighbours[c] = detail::sides_of_box(scene, c * chunk_size, 1);
    of_any[c] = detail::sides_of_box(scene, c, count);
  }
  const auto half = of_any.begin() + std::ptrdiff_t(count / 2);
  std::nth_element(of_any.begin(), half, of_any.end());
  const double most = 4 * *half;
  const auto sum = [most](const std::vector<double>& sides) {
    double all = 0;
    for (const double side : sides) all += std::min(side, most);
    return all;
  };
  if (!(sum(of_neighbours) < 0.5 * sum(of_any))) return {};
  std::vector<ChunkBounds> chunks(count);
  for (std::size_t c = 0; c < count; ++c) chunks[c] = detail::bounds_of_chunk(scene, c);
  return chunks;
}

/// Which chunks a view cannot show: none of their Gaussians is `visible` to `project_shape`.
///
/// A Gaussian of size s at (X, Y, Z) in camera space has a splat of the half width
/// k sqrt((fx s |W0 - tx W2| / Z)^2 + blur) at most, where k^2 = 2 ln(opacity / alpha_min), W are the rows of
/// the camera's rotation, and tx lies within the limits of the linearised projection. So it is right of the
/// image if fx X / Z + cx - k (fx s L / Z + sqrt(blur)) > right, with L the largest |W0 - tx W2|. Times Z
/// that is linear in X and Z, and a box is on one side of it where its corner is. The three other sides are
/// alike. Through a lens that is no pinhole, a box is bounded by `box_through`.
class ChunkCuller {
 public:
  SWIFTGS_HD explicit ChunkCuller(const ViewConstants& view) : view_(&view) {
    const double of_x = lengths(0, view.limits.least_u, view.limits.most_u) * view.fx;
    const double of_y = lengths(1, view.limits.least_v, view.limits.most_v) * view.fy;
    // The slack of projection is 2e-4 of both half sizes; the rest is for roundings.
    wide_ = 1.001 * of_x + 3e-4 * of_y, high_ = 1.001 * of_y + 3e-4 * of_x;
    blur_ = 1.002 * std::sqrt(double(view.blur));
  }

  /// A number that is NaN, or an infinity that may reach the image, culls nothing.
  SWIFTGS_HD bool culls(const ChunkBounds& chunk) const {
    const ViewConstants& v = *view_;
    const float opacity = v.opacity * chunk.opacity;
    if (opacity < v.alpha_min) return true;
    // To camera space. Roundings are less than `rounding` along each axis.
    double centre[3], half[3], rounding = 0;
    for (int k = 0; k < 3; ++k) {
      const double low = chunk.low[k] - v.centre[k], high = chunk.high[k] - v.centre[k];
      centre[k] = 0.5 * (low + high), half[k] = 0.5 * (high - low);
      rounding += 1e-6 * (std::fabs(low) + std::fabs(high));
    }
    // Largest value of `x`, `y` and `z` times the camera's axes over the box.
    const auto most = [&](double x, double y, double z) {
      double sum = 0;
      for (int k = 0; k < 3; ++k) {
        const double row = x * v.rotation[0][k] + y * v.rotation[1][k] + z * v.rotation[2][k];
        sum += row * centre[k] + std::fabs(row) * half[k];
      }
      return sum + (std::fabs(x) + std::fabs(y) + std::fabs(z)) * rounding;
    };
    if (v.depth_is_distance ? culled_by_distance(centre, half, rounding)
                            : v.depth_scale * most(0, 0, 1) <= v.near_plane ||
                                  v.depth_scale * most(0, 0, -1) < -double(v.far_plane))
      return true;
    const double k = std::sqrt(2.0 * std::log(1.0001f * opacity / v.alpha_min));
    if (v.through_lens) return culled_through_lens(chunk, k, box_of(centre, half, rounding));
    const double margin = 0.03 + k * blur_, size = k * double(chunk.size);
    const double x = size * wide_, y = size * high_;
    return most(-v.fx, 0, v.right - v.cx + margin) < -x || most(v.fx, 0, v.cx - v.left + margin) < -x ||
           most(0, -v.fy, v.bottom - v.cy + margin) < -y || most(0, v.fy, v.cy - v.top + margin) < -y;
  }

  /// Half width and height of a splat for k = size = z = 1, and the blur. @units{pixels}
  double wide() const { return wide_; }
  double high() const { return high_; }
  double blur() const { return blur_; }

 private:
  /// Whether all of a box is nearer or further than what is shown. The rotation may lengthen by 1e-3.
  SWIFTGS_HD bool culled_by_distance(const double (&centre)[3], const double (&half)[3],
                                     double rounding) const {
    double nearest = 0, furthest = 0;
    for (int k = 0; k < 3; ++k) {
      const double to = std::fabs(centre[k]), near = std::fmax(to - half[k] - rounding, 0.0);
      nearest += near * near, furthest += (to + half[k] + rounding) * (to + half[k] + rounding);
    }
    const double scale = view_->depth_scale;
    return 1.002 * scale * std::sqrt(furthest) <= view_->near_plane ||
           0.998 * scale * std::sqrt(nearest) > view_->far_plane;
  }

  /// A box along the camera's axes around one along the world's.
  SWIFTGS_HD CameraBox box_of(const double (&centre)[3], const double (&half)[3], double rounding) const {
    CameraBox box;
    for (int row = 0; row < 3; ++row) {
      box.half[row] = rounding;
      for (int k = 0; k < 3; ++k) {
        box.centre[row] += view_->rotation[row][k] * centre[k];
        box.half[row] += std::fabs(view_->rotation[row][k]) * half[k];
      }
    }
    return box;
  }

  /// Whether the lens shows no splat of a box in this part of the image. A splat's half width is at most
  /// sqrt((k fx |du| size)^2 + k^2 blur), with du the derivative of u by the point. Not inlined: it would
  /// cost pinhole views registers.
  SWIFTGS_HD SWIFTGS_NOINLINE bool culled_through_lens(const ChunkBounds& chunk, double k,
                                                       const CameraBox& box) const {
    const ViewConstants& v = *view_;
    const LensBox seen = box_through(v.lens, v.limits, box);
    if (!seen.inside) return true;
    if (!seen.bounded) return false;
    // The rotation may lengthen by 1e-3. The slack of projection is 2e-4 of both half sizes.
    const double size = 1.002 * k * double(chunk.size), wide = size * v.fx * seen.du,
                 high = size * v.fy * seen.dv;
    const double margin = 0.03 + k * blur_ + 4e-4 * (wide + high);
    const double reach_x = 1.001 * v.fx * seen.half_u + wide + margin + 1e-6 * std::fabs(v.fx * seen.u);
    const double reach_y = 1.001 * v.fy * seen.half_v + high + margin + 1e-6 * std::fabs(v.fy * seen.v);
    const double y = v.fy * seen.v + v.cy;
    if (y + reach_y < v.top || y - reach_y > v.bottom) return true;
    const double x = v.nearest_copy(v.fx * seen.u + v.cx);
    if (v.turn == 0) return x + reach_x < v.left || x - reach_x > v.right;
    // The copy that a Gaussian of the box is shown at may be at the other side of the middle.
    const double shown =
        std::fmax(std::fabs(v.left - v.panorama_middle), std::fabs(v.right - v.panorama_middle));
    return std::fabs(x - v.panorama_middle) - reach_x > shown;
  }

  /// Largest length of W_row - t W2 for t between `low` and `high`: that of an end.
  SWIFTGS_HD double lengths(int row, double low, double high) const {
    double at_low = 0, at_high = 0;
    for (int k = 0; k < 3; ++k) {
      const double a = view_->rotation[row][k] - low * view_->rotation[2][k];
      const double b = view_->rotation[row][k] - high * view_->rotation[2][k];
      at_low += a * a, at_high += b * b;
    }
    return std::sqrt(at_low > at_high ? at_low : at_high);
  }

  const ViewConstants* view_;
  double wide_, high_, blur_;
};

}  // namespace swiftgs
