// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How far a lens can be trusted, found on the host once a frame.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <vector>

#include <swiftgs/camera.hpp>
#include <swiftgs/conventions.hpp>
#include <swiftgs/lens/point.hpp>

namespace swiftgs {

namespace lens {

/// Coefficients of a polynomial, that of the constant first.
using Polynomial = std::vector<double>;

inline double value_at(const Polynomial& c, double s) {
  double sum = 0;
  for (std::size_t i = c.size(); i-- > 0;) sum = sum * s + c[i];
  return sum;
}

inline Polynomial derivative(const Polynomial& c) {
  Polynomial out;
  for (std::size_t i = 1; i < c.size(); ++i) out.push_back(double(i) * c[i]);
  return out;
}

inline Polynomial product(const Polynomial& a, const Polynomial& b) {
  Polynomial out(a.size() + b.size() - 1);
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < b.size(); ++j) out[i + j] += a[i] * b[j];
  return out;
}

/// Where `c` changes its sign between 0 and `end`, ascending: the last number before each change. Between
/// neighbouring sign changes of its derivative a polynomial is monotonic and changes its sign at most once.
inline std::vector<double> sign_changes(const Polynomial& c, double end) {
  if (c.size() < 2) return {};
  std::vector<double> stations = sign_changes(derivative(c), end), found;
  stations.push_back(end);
  double low = 0;
  for (const double high : stations) {
    const bool positive = value_at(c, low) > 0;
    if (positive != (value_at(c, high) > 0)) {
      double before = low, behind = high;
      for (double middle; (middle = 0.5 * (before + behind)) > before && middle < behind;)
        ((value_at(c, middle) > 0) == positive ? before : behind) = middle;
      found.push_back(before);
    }
    low = high;
  }
  return found;
}

/// r^2 of the plane up to which radii grow under `d` and the rational term has no pole, at most `end`.
inline double fold_squared(const Distortion& d, double end) {
  const Polynomial above{1, d.radial[0], d.radial[1], d.radial[2], d.radial[3]};
  const Polynomial below{1, d.rational[0], d.rational[1], d.rational[2]};
  // The derivative of r above / below by r, times below^2: above below + 2 s (above' below - above below').
  Polynomial growth = product(above, below);
  const Polynomial gain = product(derivative(above), below), loss = product(above, derivative(below));
  for (std::size_t i = 0; i < gain.size(); ++i) growth[i + 1] += 2 * gain[i];
  for (std::size_t i = 0; i < loss.size(); ++i) growth[i + 1] -= 2 * loss[i];
  double least = end;
  for (const Polynomial& one : {growth, below})
    for (const double s : sign_changes(one, end)) least = std::min(least, s);
  return least;
}

/// The point of the plane that `d` moves to (u, v), within the fold; nothing where there is none. Follows the
/// line from the centre to (u, v), with Newton's method at every step.
inline std::optional<dvec3> undistorted(const Distortion& d, double fold_squared, double u, double v) {
  constexpr int steps = 32, most_iterations = 20;
  double x = 0, y = 0;
  for (int step = 1; step <= steps; ++step) {
    const double to_u = u * step / steps, to_v = v * step / steps;
    const double near_enough = 1e-14 * (std::fabs(to_u) + std::fabs(to_v));
    for (int n = 0;; ++n) {
      const Distorted at = distort(d, x, y);
      const double off_u = to_u - at.u, off_v = to_v - at.v;
      if (std::fabs(off_u) + std::fabs(off_v) <= near_enough) break;
      if (n == most_iterations) {
        if (std::fabs(off_u) + std::fabs(off_v) <= 1e-9 * (1 + std::fabs(to_u) + std::fabs(to_v))) break;
        return {};
      }
      const double determinant = at.uu * at.vv - at.uv * at.vu;
      if (!(determinant > 0)) return {};
      x += (at.vv * off_u - at.uv * off_v) / determinant, y += (at.uu * off_v - at.vu * off_u) / determinant;
      if (!(x * x + y * y < fold_squared)) return {};
    }
  }
  return dvec3(x, y, 1);
}

/// Least and largest tangents that the image shows along both axes, wherever the principal point is. A border
/// that lies beyond the fold is taken to show tangents up to the fold.
inline LensLimits tangents_of_image(const Camera& camera, double fold_squared) {
  constexpr int along_side = 64;
  const double fold = std::sqrt(fold_squared);
  LensLimits out{.fold_squared = fold_squared,
                 .least_u = INFINITY,
                 .most_u = -INFINITY,
                 .least_v = INFINITY,
                 .most_v = -INFINITY};
  const auto add = [&](double pixel_x, double pixel_y) {
    const double u = (pixel_x - camera.cx) / camera.fx, v = (pixel_y - camera.cy) / camera.fy;
    const double radius = std::sqrt(u * u + v * v);
    const dvec3 at =
        undistorted(camera.lens.distortion, fold_squared, u, v)
            .value_or(radius > 0 ? dvec3(u / radius * fold, v / radius * fold, 1) : dvec3(0, 0, 1));
    out.least_u = std::min(out.least_u, at.x), out.most_u = std::max(out.most_u, at.x);
    out.least_v = std::min(out.least_v, at.y), out.most_v = std::max(out.most_v, at.y);
  };
  for (int i = 0; i <= along_side; ++i) {
    const double x = double(camera.width) * i / along_side, y = double(camera.height) * i / along_side;
    add(x, 0), add(x, camera.height), add(0, y), add(camera.width, y);
  }
  return out;
}

}  // namespace lens

/// The limits of a camera's lens. Those of tangents are 0.3 tan(fov / 2) beyond what the image shows, or 1.3
/// tan(fov / 2) to each side of the axis, as `Conventions::JacobianClamp` says for pinholes.
inline LensLimits lens_limits(const Camera& camera, const Conventions& conventions) {
  constexpr double pi = std::numbers::pi;
  // Behind the camera a fisheye lens shows one point as a circle.
  constexpr double widest = pi - 1e-3, largest_tangent = 1e6;
  switch (camera.lens.model) {
    case LensModel::perspective: {
      LensLimits out = lens::tangents_of_image(
          camera, lens::fold_squared(camera.lens.distortion, largest_tangent * largest_tangent));
      const double half_u = 0.5 * (out.most_u - out.least_u), half_v = 0.5 * (out.most_v - out.least_v);
      if (conventions.clamp == Conventions::JacobianClamp::around_image) {
        out.least_u -= 0.3 * half_u, out.most_u += 0.3 * half_u;
        out.least_v -= 0.3 * half_v, out.most_v += 0.3 * half_v;
      } else {
        out.least_u = -1.3 * half_u, out.most_u = 1.3 * half_u;
        out.least_v = -1.3 * half_v, out.most_v = 1.3 * half_v;
      }
      return out;
    }
    case LensModel::fisheye:
      return {.fold_squared = lens::fold_squared(camera.lens.distortion, widest * widest)};
    case LensModel::orthographic:
      return {};
    case LensModel::equirectangular:
      return {.least_polar = std::min(1 / std::fabs(camera.fy), 0.1)};
  }
  return {};
}

}  // namespace swiftgs
