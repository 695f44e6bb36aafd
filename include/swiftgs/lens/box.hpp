// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a lens makes of all points of a box: bounds of `point_through`.

#include <cmath>

#include <swiftgs/lens/point.hpp>

namespace swiftgs {

/// A box along the axes of camera space.
struct CameraBox {
  dvec3 centre{0.0}, half{0.0};
};

/// Where a lens shows the points of a box. `du` and `dv` are the largest lengths of the derivatives of u and
/// v.
struct LensBox {
  double u = 0, v = 0, half_u = 0, half_v = 0;
  double du = 0, dv = 0;
  bool bounded = false;  ///< else nothing is known
  bool inside = true;    ///< the lens may show points of the box
};

namespace lens {

/// All numbers between two. NaN where nothing is known.
struct Interval {
  double low, high;

  SWIFTGS_HD double most() const { return std::fmax(std::fabs(low), std::fabs(high)); }
  SWIFTGS_HD double least() const { return low > 0 ? low : high < 0 ? -high : 0; }
};

SWIFTGS_HD inline Interval operator+(const Interval& a, const Interval& b) {
  return {a.low + b.low, a.high + b.high};
}
SWIFTGS_HD inline Interval operator*(double a, const Interval& b) {
  return a < 0 ? Interval{a * b.high, a * b.low} : Interval{a * b.low, a * b.high};
}
SWIFTGS_HD inline Interval operator*(const Interval& a, const Interval& b) {
  const double ll = a.low * b.low, lh = a.low * b.high, hl = a.high * b.low, hh = a.high * b.high;
  return {std::fmin(std::fmin(ll, lh), std::fmin(hl, hh)), std::fmax(std::fmax(ll, lh), std::fmax(hl, hh))};
}
SWIFTGS_HD inline Interval square(const Interval& a) { return {a.least() * a.least(), a.most() * a.most()}; }
/// c0 + c1 s + c2 s^2 + c3 s^3 + c4 s^4
SWIFTGS_HD inline Interval polynomial(const Interval& s, double c0, double c1, double c2, double c3,
                                      double c4) {
  const auto one = [](double c) { return Interval{c, c}; };
  return one(c0) + s * (one(c1) + s * (one(c2) + s * (one(c3) + c4 * s)));
}

/// A box of the plane.
struct PlaneBox {
  Interval u, v;

  SWIFTGS_HD Interval radius_squared() const { return square(u) + square(v); }
};

/// Largest magnitudes of the derivatives in `Distorted` over `box`; infinite where a pole may be in it.
SWIFTGS_HD inline Distorted most_distorted(const Distortion& d, const PlaneBox& box) {
  const Interval &u = box.u, &v = box.v, s = box.radius_squared();
  const double* k = d.radial;
  const double* q = d.rational;
  const Interval below = polynomial(s, 1, q[0], q[1], q[2], 0);
  if (!(below.low > 0)) return {0, 0, INFINITY, INFINITY, INFINITY, INFINITY};
  const Interval inverse{1 / below.high, 1 / below.low};
  const Interval ratio = polynomial(s, 1, k[0], k[1], k[2], k[3]) * inverse;
  const Interval by_s = (polynomial(s, k[0], 2 * k[1], 3 * k[2], 4 * k[3], 0) +
                         -1.0 * (ratio * polynomial(s, q[0], 2 * q[1], 3 * q[2], 0, 0))) *
                        inverse;
  const double p0 = d.tangential[0], p1 = d.tangential[1], s0 = d.prism[0], s1 = d.prism[1];
  const Interval cross = 2 * (by_s * (u * v) + p0 * u + p1 * v);
  return {0,
          0,
          (ratio + 2 * (by_s * square(u) + p0 * v + (3 * p1 + s0) * u)).most(),
          (cross + 2 * s0 * v).most(),
          (cross + 2 * s1 * u).most(),
          (ratio + 2 * (by_s * square(v) + (3 * p0 + s1) * v + p1 * u)).most()};
}

/// Moves `box` by a distortion, by the mean value theorem.
SWIFTGS_HD inline LensBox distorted_box(const Distortion& d, const PlaneBox& box) {
  const double half_u = 0.5 * (box.u.high - box.u.low), half_v = 0.5 * (box.v.high - box.v.low);
  const Distorted middle = distort(d, box.u.low + half_u, box.v.low + half_v);
  const Distorted most = most_distorted(d, box);
  LensBox out;
  out.u = middle.u, out.v = middle.v;
  out.half_u = most.uu * half_u + most.uv * half_v, out.half_v = most.vu * half_u + most.vv * half_v;
  return out;
}

SWIFTGS_HD inline Interval hull(const Interval& a, const Interval& b) {
  return {std::fmin(a.low, b.low), std::fmax(a.high, b.high)};
}

/// x / z for z > 0
SWIFTGS_HD inline Interval tangents(const Interval& x, const Interval& z) {
  return {x.low / (x.low < 0 ? z.low : z.high), x.high / (x.high < 0 ? z.high : z.low)};
}

SWIFTGS_HD inline LensBox perspective(const Distortion& d, const LensLimits& limits, const CameraBox& box) {
  const auto along = [&](int k) {
    return Interval{box.centre[k] - box.half[k], box.centre[k] + box.half[k]};
  };
  const Interval z = along(2);
  LensBox out;
  out.inside = !(z.high <= 0);
  if (!(z.low > 0)) return out;
  const PlaneBox seen{tangents(along(0), z), tangents(along(1), z)};
  out = distorted_box(d, seen);
  out.inside = !(seen.radius_squared().low >= limits.fold_squared);
  // Derivatives are taken at the limited tangents, and also at the unlimited ones if limited ones reach the
  // fold.
  const auto within = [](const Interval& t, double least, double most) {
    return Interval{clamped(t.low, least, most), clamped(t.high, least, most)};
  };
  PlaneBox at{within(seen.u, limits.least_u, limits.most_u), within(seen.v, limits.least_v, limits.most_v)};
  if (!(at.radius_squared().high < limits.fold_squared)) at = {hull(at.u, seen.u), hull(at.v, seen.v)};
  const Distorted most = most_distorted(d, at);
  const double u = std::sqrt(1 + square(at.u).high) / z.low, v = std::sqrt(1 + square(at.v).high) / z.low;
  out.du = most.uu * u + most.uv * v, out.dv = most.vu * u + most.vv * v;
  out.bounded = true;
  return out;
}

/// The directions of a box, seen from the camera, are within an angle of that of its centre.
struct Cone {
  double distance, nearest;  ///< of the centre; of the box at least
  double half_angle;
  bool narrow;

  SWIFTGS_HD explicit Cone(const CameraBox& box) : distance(length(box.centre)) {
    const double radius = length(box.half);
    nearest = distance - radius, narrow = nearest > 1e-3 * distance;
    half_angle = narrow ? std::asin(radius / distance) : INFINITY;
  }

 private:
  SWIFTGS_HD static double length(const dvec3& a) { return std::sqrt(a.x * a.x + a.y * a.y + a.z * a.z); }
};

/// A step of the direction moves the point of the plane by angle / sin(angle) times it at most: by so much
/// about the axis, by 1 away from it.
SWIFTGS_HD inline LensBox fisheye(const Distortion& d, const LensLimits& limits, const CameraBox& box) {
  constexpr double widest = 3.14;
  const Cone cone(box);
  const dvec3& c = box.centre;
  LensBox out;
  if (!cone.narrow) return out;
  const double across = std::sqrt(c.x * c.x + c.y * c.y), angle = std::atan2(across, c.z);
  const double nearest = angle - cone.half_angle, furthest = angle + cone.half_angle;
  out.inside = !(nearest > 0 && nearest * nearest >= limits.fold_squared);
  if (!(furthest < widest)) return out;
  const double stretch = furthest < 1e-3 ? 1.001 : furthest / std::sin(furthest);
  const double u = across > 0 ? angle * c.x / across : 0, v = across > 0 ? angle * c.y / across : 0;
  const double half = cone.half_angle * stretch;
  const PlaneBox seen{{u - half, u + half}, {v - half, v + half}};
  const bool inside = out.inside;
  out = distorted_box(d, seen);
  const Distorted most = most_distorted(d, seen);
  out.du = (most.uu + most.uv) * stretch / cone.nearest,
  out.dv = (most.vu + most.vv) * stretch / cone.nearest;
  out.inside = inside, out.bounded = true;
  return out;
}

SWIFTGS_HD inline LensBox orthographic(const CameraBox& box) {
  return {box.centre.x, box.centre.y, box.half.x, box.half.y, 1, 1, true, true};
}

/// Azimuths as a cone seen from above has them.
SWIFTGS_HD inline LensBox equirectangular(const CameraBox& box) {
  const dvec3& c = box.centre;
  const Cone cone(box), level({dvec3(c.x, 0, c.z), dvec3(box.half.x, 0, box.half.z)});
  LensBox out;
  if (!cone.narrow || !level.narrow) return out;
  out.u = std::atan2(c.x, c.z), out.v = std::atan2(c.y, level.distance);
  out.half_u = level.half_angle, out.half_v = cone.half_angle;
  out.du = 1 / level.nearest, out.dv = 1 / cone.nearest;
  out.bounded = true;
  return out;
}

}  // namespace lens

/// Bounds of what `of` makes of the points of `box`, up to roundings of 1e-9 of the numbers. Three kinds of
/// boxes are not bounded: those that reach behind a perspective lens, that hold the camera, and that hold
/// directions which the lens shows as a line.
SWIFTGS_HD inline LensBox box_through(const Lens& of, const LensLimits& limits, const CameraBox& box) {
  switch (of.model) {
    case LensModel::perspective:
      return lens::perspective(of.distortion, limits, box);
    case LensModel::fisheye:
      return lens::fisheye(of.distortion, limits, box);
    case LensModel::orthographic:
      return lens::orthographic(box);
    case LensModel::equirectangular:
      return lens::equirectangular(box);
  }
  return {};
}

}  // namespace swiftgs
