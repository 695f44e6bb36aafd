// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Where a lens shows a point, and how the image moves with the point.

#include <cmath>

#include <swiftgs/lens.hpp>
#include <swiftgs/math.hpp>

namespace swiftgs {

/// A point seen through a lens: its place (u, v) in the plane, before focal lengths and principal point, and
/// the derivatives of both by the point in camera space.
struct LensPoint {
  double u = 0, v = 0;
  dvec3 du{0.0}, dv{0.0};
  bool inside = false;  ///< the lens shows points there
};

/// What a lens keeps of its points, found once a frame.
struct LensLimits {
  /// Points whose undistorted r^2 is not below are beyond the fold-over of the distortion.
  double fold_squared = INFINITY;
  /// The derivatives of a perspective lens are taken within these tangents.
  double least_u = -INFINITY, most_u = INFINITY, least_v = -INFINITY, most_v = INFINITY;
  /// Those of an equirectangular lens are taken at least so far from its poles. @units{radians}
  double least_polar = 0;
};

namespace lens {

/// A point of the plane moved by a distortion, and the derivatives.
struct Distorted {
  double u, v;
  double uu, uv, vu, vv;  ///< of u by u and v, and of v by u and v
};

/// Both as `Distortion` has them.
SWIFTGS_HD inline Distorted distort(const Distortion& d, double u, double v) {
  const double s = u * u + v * v;
  const double* k = d.radial;
  const double* q = d.rational;
  const double above = std::fma(s, std::fma(s, std::fma(s, std::fma(s, k[3], k[2]), k[1]), k[0]), 1.0);
  const double below = std::fma(s, std::fma(s, std::fma(s, q[2], q[1]), q[0]), 1.0);
  const double above_by_s = std::fma(s, std::fma(s, std::fma(s, 4 * k[3], 3 * k[2]), 2 * k[1]), k[0]);
  const double below_by_s = std::fma(s, std::fma(s, 3 * q[2], 2 * q[1]), q[0]);
  const double ratio = above / below, by_s = (above_by_s - ratio * below_by_s) / below;
  const double p0 = d.tangential[0], p1 = d.tangential[1], s0 = d.prism[0], s1 = d.prism[1];
  const double cross = 2 * (by_s * u * v + p0 * u + p1 * v);
  return {u * ratio + 2 * p0 * u * v + p1 * (s + 2 * u * u) + s0 * s,
          v * ratio + p0 * (s + 2 * v * v) + 2 * p1 * u * v + s1 * s,
          ratio + 2 * (by_s * u * u + p0 * v + 3 * p1 * u + s0 * u),
          cross + 2 * s0 * v,
          cross + 2 * s1 * u,
          ratio + 2 * (by_s * v * v + 3 * p0 * v + p1 * u + s1 * v)};
}

/// Whether the distortion neither turns the image over there nor turns it by half.
SWIFTGS_HD inline bool keeps_sides(const Distorted& at) {
  return at.uu * at.vv - at.uv * at.vu > 0 && at.uu + at.vv > 0;
}

/// Chains the distortion at (u, v) behind `at`, whose derivatives are those of (u, v).
SWIFTGS_HD inline void chain(LensPoint& at, const Distorted& by) {
  const dvec3 du = at.du, dv = at.dv;
  at.du = by.uu * du + by.uv * dv, at.dv = by.vu * du + by.vv * dv;
}

SWIFTGS_HD inline double clamped(double x, double least, double most) {
  return x < least ? least : x > most ? most : x;
}

/// The place is exact; the derivatives are those at tangents within the limits, as for pinholes.
SWIFTGS_HD inline LensPoint perspective(const Distortion& d, const LensLimits& limits, const dvec3& p) {
  const double inverse_z = 1 / p.z, u = p.x * inverse_z, v = p.y * inverse_z;
  const Distorted place = distort(d, u, v);
  LensPoint out;
  out.u = place.u, out.v = place.v;
  double at_u = clamped(u, limits.least_u, limits.most_u), at_v = clamped(v, limits.least_v, limits.most_v);
  if (!(at_u * at_u + at_v * at_v < limits.fold_squared)) at_u = u, at_v = v;  // a corner of the limits
  out.du = dvec3(inverse_z, 0, -at_u * inverse_z), out.dv = dvec3(0, inverse_z, -at_v * inverse_z);
  chain(out, at_u == u && at_v == v ? place : distort(d, at_u, at_v));
  // Before the fold, radii grow; tangential terms may fold the image elsewhere.
  out.inside = p.z > 0 && u * u + v * v < limits.fold_squared && keeps_sides(place);
  return out;
}

SWIFTGS_HD inline LensPoint fisheye(const Distortion& d, const LensLimits& limits, const dvec3& p) {
  const double across_squared = p.x * p.x + p.y * p.y, across = std::sqrt(across_squared);
  const double squared = across_squared + p.z * p.z, angle = std::atan2(across, p.z);
  const bool on_axis = across == 0;
  const double x = on_axis ? 1 : p.x / across, y = on_axis ? 0 : p.y / across;
  // The plane moves by `along` with a step away from the axis, by `around` with one about it.
  const double along = p.z / squared, around = on_axis ? 1 / p.z : angle / across;
  const double mixed = x * y * (along - around);
  LensPoint out;
  const double u = angle * x, v = angle * y;
  out.du = dvec3(x * x * along + y * y * around, mixed, -p.x / squared);
  out.dv = dvec3(mixed, y * y * along + x * x * around, -p.y / squared);
  const Distorted by = distort(d, u, v);
  out.u = by.u, out.v = by.v;
  chain(out, by);
  out.inside = angle * angle < limits.fold_squared && keeps_sides(by);
  return out;
}

SWIFTGS_HD inline LensPoint orthographic(const dvec3& p) {
  return {p.x, p.y, dvec3(1, 0, 0), dvec3(0, 1, 0), true};
}

/// Near a pole, where azimuths crowd, the derivatives are those at `LensLimits::least_polar` from it.
SWIFTGS_HD inline LensPoint equirectangular(const LensLimits& limits, const dvec3& p) {
  const double level_squared = p.x * p.x + p.z * p.z, level = std::sqrt(level_squared);
  const double squared = level_squared + p.y * p.y, distance = std::sqrt(squared);
  const double least = distance * std::sin(limits.least_polar);
  const double radius = level > least ? level : least;
  const double x = p.x / level, z = p.z / level;  // where the azimuth points
  LensPoint out;
  out.u = std::atan2(p.x, p.z), out.v = std::atan2(p.y, level);
  out.du = dvec3(z / radius, 0, -x / radius);
  out.dv = dvec3(-p.y * x / squared, level / squared, -p.y * z / squared);
  out.inside = level > 0;  // a pole has every azimuth
  return out;
}

}  // namespace lens

/// Where `of` shows the point `p` of camera space.
SWIFTGS_HD inline LensPoint point_through(const Lens& of, const LensLimits& limits, const dvec3& p) {
  switch (of.model) {
    case LensModel::perspective:
      return lens::perspective(of.distortion, limits, p);
    case LensModel::fisheye:
      return lens::fisheye(of.distortion, limits, p);
    case LensModel::orthographic:
      return lens::orthographic(p);
    case LensModel::equirectangular:
      return lens::equirectangular(limits, p);
  }
  return {};
}

}  // namespace swiftgs
