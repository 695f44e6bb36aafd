// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The oracle's lenses in long double, written from docs/planes.md. Derivatives are carried beside
/// values.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <swiftgs/camera.hpp>
#include <swiftgs/conventions.hpp>

#include "reference/oracle_projection.hpp"

namespace swiftgs::test {

/// A number and its derivatives by a point in camera space.
struct Dual {
  Real value = 0;
  Real3 by{};

  Dual(Real v) : value(v) {}
  Dual(Real v, const Real3& d) : value(v), by(d) {}

  /// f(*this), with f and its derivative at the value.
  Dual through(Real f, Real slope) const { return {f, {slope * by[0], slope * by[1], slope * by[2]}}; }

  friend Dual operator+(const Dual& a, const Dual& b) {
    return {a.value + b.value, {a.by[0] + b.by[0], a.by[1] + b.by[1], a.by[2] + b.by[2]}};
  }
  friend Dual operator*(const Dual& a, const Dual& b) {
    Dual out(a.value * b.value);
    for (std::size_t k = 0; k < 3; ++k) out.by[k] = a.value * b.by[k] + b.value * a.by[k];
    return out;
  }
  friend Dual operator/(const Dual& a, const Dual& b) {
    return a * b.through(1 / b.value, -1 / (b.value * b.value));
  }
};

inline Dual root(const Dual& a) { return a.through(std::sqrt(a.value), 1 / (2 * std::sqrt(a.value))); }
inline Dual angle(const Dual& y, const Dual& x) {
  const Real squared = x.value * x.value + y.value * y.value;
  const Dual turned = y.through(0, x.value / squared) + x.through(0, -y.value / squared);
  return {std::atan2(y.value, x.value), turned.by};
}

/// Where a lens shows a point, before focal lengths.
struct Sight {
  Dual u = 0, v = 0;
  bool inside = true;
};

inline Sight distorted(const Distortion& d, const Sight& s) {
  const Dual &u = s.u, &v = s.v, r2 = u * u + v * v, r4 = r2 * r2;
  const auto& k = d.radial;
  const auto& q = d.rational;
  const Dual ratio = (1 + k[0] * r2 + k[1] * r4 + k[2] * r2 * r4 + k[3] * r4 * r4) /
                     (1 + q[0] * r2 + q[1] * r4 + q[2] * r2 * r4);
  const Real p0 = d.tangential[0], p1 = d.tangential[1];
  return {u * ratio + 2 * p0 * u * v + p1 * (r2 + 2 * u * u) + d.prism[0] * r2,
          v * ratio + p0 * (r2 + 2 * v * v) + 2 * p1 * u * v + d.prism[1] * r2, s.inside};
}

/// Whether radii grow up to (u, v) and the distortion keeps the image's sides there.
inline bool before_fold(const Distortion& d, Real u, Real v) {
  const auto& k = d.radial;
  const auto& q = d.rational;
  constexpr int steps = 2000;
  for (int i = 1; i <= steps; ++i) {
    const Dual s((u * u + v * v) * i / steps, {1, 0, 0}), s2 = s * s;
    const Dual below = 1 + q[0] * s + q[1] * s2 + q[2] * s * s2;
    const Dual ratio = (1 + k[0] * s + k[1] * s2 + k[2] * s * s2 + k[3] * s2 * s2) / below;
    if (!(below.value > 0 && ratio.value + 2 * s.value * ratio.by[0] > 0)) return false;
  }
  const Sight moved = distorted(d, {Dual(u, {1, 0, 0}), Dual(v, {0, 1, 0})});
  return moved.u.by[0] * moved.v.by[1] - moved.u.by[1] * moved.v.by[0] > 0 &&
         moved.u.by[0] + moved.v.by[1] > 0;
}

/// The tangents that `d` moves to (u, v), by a fixed point.
inline std::array<Real, 2> undistorted(const Distortion& d, Real u, Real v) {
  Real x = u, y = v;
  for (int n = 0; n < 500; ++n) {
    const Sight at = distorted(d, {x, y});
    if (at.u.value == u && at.v.value == v) break;
    x += u - at.u.value, y += v - at.v.value;
  }
  return {x, y};
}

/// Limits the tangents at which projection through a perspective lens is linearised. A distorted lens must
/// show most at the corners of its image.
inline void limit(Real& u, Real& v, const Camera& camera, Conventions::JacobianClamp clamp) {
  Real least[2] = {INFINITY, INFINITY}, most[2] = {-INFINITY, -INFINITY};
  for (const int x : {0, camera.width})
    for (const int y : {0, camera.height}) {
      const auto corner = undistorted(camera.lens.distortion, (x - Real(camera.cx)) / camera.fx,
                                      (y - Real(camera.cy)) / camera.fy);
      for (std::size_t i = 0; i < 2; ++i)
        least[i] = std::min(least[i], corner[i]), most[i] = std::max(most[i], corner[i]);
    }
  Real* const tangents[2] = {&u, &v};
  for (std::size_t i = 0; i < 2; ++i) {
    const Real half = (most[i] - least[i]) / 2;
    const bool image = clamp == Conventions::JacobianClamp::around_image;
    const Real low = image ? least[i] - 0.3L * half : -1.3L * half,
               high = image ? most[i] + 0.3L * half : 1.3L * half;
    *tangents[i] = std::min(high, std::max(low, *tangents[i]));
  }
}

/// What a lens that is no pinhole makes of the point `at` of camera space.
inline Sight sight(const Camera& camera, const Conventions& conventions, const Real3& at) {
  const Dual x(at[0], {1, 0, 0}), y(at[1], {0, 1, 0}), z(at[2], {0, 0, 1});
  switch (camera.lens.model) {
    case LensModel::perspective: {
      if (!(at[2] > 0)) return {.inside = false};
      const Real u = at[0] / at[2], v = at[1] / at[2];
      Real at_u = u, at_v = v;
      limit(at_u, at_v, camera, conventions.clamp);
      Sight seen = distorted(camera.lens.distortion, {Dual(at_u, {1 / at[2], 0, -at_u / at[2]}),
                                                      Dual(at_v, {0, 1 / at[2], -at_v / at[2]})});
      const Sight place = distorted(camera.lens.distortion, {u, v});
      seen.u.value = place.u.value, seen.v.value = place.v.value;
      seen.inside = before_fold(camera.lens.distortion, u, v);
      return seen;
    }
    case LensModel::fisheye: {
      const Dual across = root(x * x + y * y), theta = angle(across, z);
      const Dual u = theta * x / across, v = theta * y / across;
      return distorted(camera.lens.distortion, {u, v, before_fold(camera.lens.distortion, u.value, v.value)});
    }
    case LensModel::orthographic:
      return {x, y};
    case LensModel::equirectangular: {
      const Real part = panorama_part(camera), turn = 2 * std::acos(Real(-1));
      Sight seen{angle(x, z), angle(y, root(x * x + z * z))};
      // Of a camera that shows one part: the copy that is nearest to its middle.
      const Real middle = (part / 2 - camera.cx) / camera.fx;
      seen.u.value -= turn * std::round((seen.u.value - middle) / turn);
      return seen;
    }
  }
  return {};
}

/// Whether depth is the distance from the camera.
inline bool by_distance(const Camera& camera, const Conventions& k) {
  const LensModel model = camera.lens.model;
  return k.depth == Conventions::Depth::distance ||
         (k.depth == Conventions::Depth::of_lens &&
          (model == LensModel::fisheye || model == LensModel::equirectangular));
}

}  // namespace swiftgs::test
