// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Where a lens shows a point, and how the image moves with the point.

#include <cmath>

#include <swiftgs/frame/lens.hpp>
#include <swiftgs/frame/math.hpp>

namespace swiftgs::lens {
// What the formulas ask of a double.
SWIFTGS_HD inline double mul_add(double a, double b, double c) { return std::fma(a, b, c); }
SWIFTGS_HD inline double angle(double y, double x) { return std::atan2(y, x); }
SWIFTGS_HD inline double choose(bool first, double a, double b) { return first ? a : b; }
SWIFTGS_HD inline bool all(bool one) { return one; }
}  // namespace swiftgs::lens

#include <swiftgs/lens/formulas.inc>

namespace swiftgs {

/// A point seen through a lens: where it is, (u, v), in the plane, before focal lengths and principal point,
/// and the derivatives of both by the point in camera space.
struct LensPoint {
  double u = 0, v = 0;
  dvec3 du{0.0}, dv{0.0};
  bool inside = false;  ///< the lens shows points there
};

namespace lens {
using Distorted = DistortedOf<double>;
}

/// Where `of` shows the point `p` of camera space.
SWIFTGS_HD inline LensPoint point_through(const Lens& of, const LensLimits& limits, const dvec3& p) {
  const lens::SeenOf<double> seen = lens::seen_through<double>(of, limits, {p.x, p.y, p.z});
  return {seen.u, seen.v, dvec3(seen.du.x, seen.du.y, seen.du.z), dvec3(seen.dv.x, seen.dv.y, seen.dv.z),
          seen.inside};
}

}  // namespace swiftgs
