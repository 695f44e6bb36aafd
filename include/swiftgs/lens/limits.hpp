// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How far a lens can be trusted, found on the host once a frame.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include <swiftgs/camera.hpp>
#include <swiftgs/conventions.hpp>
#include <swiftgs/lens/point.hpp>

namespace swiftgs {

namespace lens {

/// A few numbers without memory of their own.
struct Numbers {
  std::array<double, 8> each{};
  std::size_t count = 0;

  void add(double number) { each[count++] = number; }
};

/// A polynomial: coefficients, that of the constant first.
using Polynomial = Numbers;

inline double value_at(const Polynomial& c, double s) {
  double sum = 0;
  for (std::size_t i = c.count; i-- > 0;) sum = sum * s + c.each[i];
  return sum;
}

inline Polynomial derivative(const Polynomial& c) {
  Polynomial out;
  for (std::size_t i = 1; i < c.count; ++i) out.add(double(i) * c.each[i]);
  return out;
}

inline Polynomial product(const Polynomial& a, const Polynomial& b) {
  Polynomial out{.count = a.count + b.count - 1};
  for (std::size_t i = 0; i < a.count; ++i)
    for (std::size_t j = 0; j < b.count; ++j) out.each[i + j] += a.each[i] * b.each[j];
  return out;
}

/// Where `c` changes its sign between 0 and `end`, ascending: the last number before each change. Between
/// neighbouring sign changes of its derivative a polynomial is monotonic and changes its sign at most once.
inline Numbers sign_changes(const Polynomial& c, double end) {
  if (c.count < 2) return {};
  Numbers stations = sign_changes(derivative(c), end), found;
  stations.add(end);
  double low = 0;
  for (std::size_t i = 0; i < stations.count; ++i) {
    const double high = stations.each[i];
    const bool positive = value_at(c, low) > 0;
    if (positive != (value_at(c, high) > 0)) {
      double before = low, behind = high;
      for (double middle; (middle = 0.5 * (before + behind)) > before && middle < behind;)
        ((value_at(c, middle) > 0) == positive ? before : behind) = middle;
      found.add(before);
    }
    low = high;
  }
  return found;
}

/// r^2 of the plane up to which radii grow under `d` and the rational term has no pole, at most `end`.
inline double fold_squared(const Distortion& d, double end) {
  const Polynomial above{{1, d.radial[0], d.radial[1], d.radial[2], d.radial[3]}, 5};
  const Polynomial below{{1, d.rational[0], d.rational[1], d.rational[2]}, 4};
  // The derivative of r above / below by r, times below^2: above below + 2 s (above' below - above below').
  Polynomial growth = product(above, below);
  const Polynomial gain = product(derivative(above), below), loss = product(above, derivative(below));
  for (std::size_t i = 0; i < gain.count; ++i) growth.each[i + 1] += 2 * gain.each[i];
  for (std::size_t i = 0; i < loss.count; ++i) growth.each[i + 1] -= 2 * loss.each[i];
  double least = end;
  for (const Polynomial& one : {growth, below}) {
    const Numbers ends = sign_changes(one, end);
    if (ends.count > 0) least = std::min(least, ends.each[0]);
  }
  return least;
}

/// A point that a distortion moves to another.
struct Undistorted {
  double u = 0, v = 0;
  bool found = false;  ///< else the nearest to it that was found on the way
};

/// Newton's method from `start` to the point within the fold that `d` moves to (u, v).
inline Undistorted solve(const Distortion& d, double fold_squared, double u, double v, Undistorted start) {
  constexpr int most_iterations = 20;
  const double near_enough = 1e-14 * (std::fabs(u) + std::fabs(v));
  Undistorted out = start;
  for (int n = 0; n < most_iterations; ++n) {
    const Distorted at = distort(d, out.u, out.v);
    const double off_u = u - at.u, off_v = v - at.v, off = std::fabs(off_u) + std::fabs(off_v);
    out.found = off <= (n + 1 == most_iterations ? 1e-9 * (1 + std::fabs(u) + std::fabs(v)) : near_enough);
    if (out.found) return out;
    if (!keeps_sides(at)) break;
    const double determinant = at.uu * at.vv - at.uv * at.vu;
    const double x = out.u + (at.vv * off_u - at.uv * off_v) / determinant;
    const double y = out.v + (at.uu * off_v - at.vu * off_u) / determinant;
    if (!(x * x + y * y < fold_squared)) break;
    out.u = x, out.v = y;
  }
  start.found = false;
  return start;
}

/// The point of the plane that `d` moves to (u, v), within the fold. Follows the line from the centre to (u,
/// v), in steps that shrink where the way ends, to a millionth of it.
inline Undistorted undistorted(const Distortion& d, double fold_squared, double u, double v) {
  Undistorted at{0, 0, true};
  double reached = 0, step = 1.0 / 16;
  constexpr int most_steps = 100;
  for (int n = 0; reached < 1 && step > 1e-6 && n < most_steps; ++n) {
    const double to = std::min(reached + step, 1.0);
    const Undistorted next = solve(d, fold_squared, u * to, v * to, at);
    if (next.found)
      at = next, reached = to, step = std::min(2 * step, 1.0 / 16);
    else
      step *= 0.25;
  }
  at.found = reached == 1;
  return at;
}

/// Least and largest tangents that the border of the image shows, wherever the principal point is. Of a
/// border that shows no point the nearest that it may show counts.
inline LensLimits tangents_of_image(const Camera& camera, double fold_squared) {
  constexpr int along_side = 32;
  LensLimits out{.fold_squared = fold_squared,
                 .least_u = INFINITY,
                 .most_u = -INFINITY,
                 .least_v = INFINITY,
                 .most_v = -INFINITY};
  Undistorted last;
  const auto add = [&](double x, double y) {
    const double u = (x * camera.width - camera.cx) / camera.fx,
                 v = (y * camera.height - camera.cy) / camera.fy;
    Undistorted at{u, v, true};
    if (camera.lens.is_distorted()) {
      // The neighbour on the border is near; only the first, and what folds, comes from the centre.
      at = last.found ? solve(camera.lens.distortion, fold_squared, u, v, last) : Undistorted();
      if (!at.found) at = undistorted(camera.lens.distortion, fold_squared, u, v);
      last = at;
    }
    out.least_u = std::min(out.least_u, at.u), out.most_u = std::max(out.most_u, at.u);
    out.least_v = std::min(out.least_v, at.v), out.most_v = std::max(out.most_v, at.v);
  };
  for (int i = 0; i < along_side; ++i) add(double(i) / along_side, 0);
  for (int i = 0; i < along_side; ++i) add(1, double(i) / along_side);
  for (int i = 0; i < along_side; ++i) add(1 - double(i) / along_side, 1);
  for (int i = 0; i < along_side; ++i) add(0, 1 - double(i) / along_side);
  return out;
}

}  // namespace lens

/// The limits of a camera's lens. Tangents are limited to 0.3 tan(fov / 2) beyond the image, or to 1.3
/// tan(fov / 2) on each side of the axis, as `Conventions::JacobianClamp` says for pinholes.
inline LensLimits lens_limits(const Camera& camera, const Conventions& conventions) {
  constexpr double pi = std::numbers::pi;
  // Behind the camera a fisheye lens shows one point as a circle.
  constexpr double widest = pi - 1e-3, largest_tangent = 1e6;
  switch (camera.lens.model) {
    case LensModel::perspective: {
      const double fold = camera.lens.is_pinhole()
                              ? INFINITY
                              : lens::fold_squared(camera.lens.distortion, largest_tangent * largest_tangent);
      LensLimits out = lens::tangents_of_image(camera, fold);
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
      return {.most_cosecant = 1 / std::sin(std::min(1 / camera.fy, 0.1))};
  }
  return {};
}

}  // namespace swiftgs
