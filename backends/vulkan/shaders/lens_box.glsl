// SPDX-License-Identifier: Apache-2.0

// What a lens makes of all points of a box, as swiftgs/lens/box.hpp has it, in floats: intervals are rounded outwards.
// tests/vulkan compiles this file as C++.

// A box along the axes of camera space.
struct CameraBox {
  vec3 centre, extent;
};

// As `LensBox`.
struct LensBox {
  float u, v, half_u, half_v, du, dv;
  bool bounded, inside;
};
FUNCTION LensBox unbounded(bool inside) {
  LensBox box;
  box.u = box.v = box.half_u = box.half_v = box.du = box.dv = 0.0f;
  box.bounded = false;
  box.inside = inside;
  return box;
}

// All numbers between two, a few units in the last place further than those given.
struct Interval {
  float low, high;
};
FUNCTION Interval interval(float low, float high) {
  Interval i;
  i.low = low - 1e-6f * abs(low);
  i.high = high + 1e-6f * abs(high);
  return i;
}
FUNCTION float most_of(Interval a) { return max(abs(a.low), abs(a.high)); }
FUNCTION float least_of(Interval a) { return max(max(a.low, -a.high), 0.0f); }
FUNCTION Interval sum_of(Interval a, Interval b) { return interval(a.low + b.low, a.high + b.high); }
FUNCTION Interval by_number(float a, Interval b) {
  return a < 0.0f ? interval(a * b.high, a * b.low) : interval(a * b.low, a * b.high);
}
FUNCTION Interval product_of(Interval a, Interval b) {
  float ll = a.low * b.low, lh = a.low * b.high, hl = a.high * b.low, hh = a.high * b.high;
  return interval(min(min(ll, lh), min(hl, hh)), max(max(ll, lh), max(hl, hh)));
}
FUNCTION Interval square_of(Interval a) {
  float least = least_of(a), most = most_of(a);
  return interval(least * least, most * most);
}
FUNCTION Interval hull_of(Interval a, Interval b) { return interval(min(a.low, b.low), max(a.high, b.high)); }
// c0 + c1 s + c2 s^2 + c3 s^3 + c4 s^4
FUNCTION Interval polynomial_of(Interval s, float c0, float c1, float c2, float c3, float c4) {
  Interval sum = sum_of(interval(c3, c3), by_number(c4, s));
  sum = sum_of(interval(c2, c2), product_of(s, sum));
  sum = sum_of(interval(c1, c1), product_of(s, sum));
  return sum_of(interval(c0, c0), product_of(s, sum));
}

// A box of the plane.
struct PlaneBox {
  Interval u, v;
};
FUNCTION Interval radius_squared(PlaneBox box) { return sum_of(square_of(box.u), square_of(box.v)); }

// Largest magnitudes of the derivatives in `Distorted` over a box; infinite where a pole may be in it.
struct MostDistorted {
  float uu, uv, vu, vv;
};
FUNCTION MostDistorted most_distorted(Eye eye, PlaneBox box) {
  Interval u = box.u, v = box.v, s = radius_squared(box);
  float k0 = eye.radial[0].high, k1 = eye.radial[1].high, k2 = eye.radial[2].high, k3 = eye.radial[3].high;
  float q0 = eye.rational[0].high, q1 = eye.rational[1].high, q2 = eye.rational[2].high;
  Interval below = polynomial_of(s, 1.0f, q0, q1, q2, 0.0f);
  MostDistorted most;
  most.uu = most.uv = most.vu = most.vv = uintBitsToFloat(0x7f800000u);
  if (!(below.low > 0.0f)) return most;
  Interval inverse = interval(1.0f / below.high, 1.0f / below.low);
  Interval ratio = product_of(polynomial_of(s, 1.0f, k0, k1, k2, k3), inverse);
  Interval of_ratio = product_of(ratio, polynomial_of(s, q0, 2.0f * q1, 3.0f * q2, 0.0f, 0.0f));
  Interval above = polynomial_of(s, k0, 2.0f * k1, 3.0f * k2, 4.0f * k3, 0.0f);
  Interval by_s = product_of(sum_of(above, by_number(-1.0f, of_ratio)), inverse);
  float p0 = eye.tangential[0].high, p1 = eye.tangential[1].high, s0 = eye.prism[0].high, s1 = eye.prism[1].high;
  Interval shared_slope = sum_of(product_of(by_s, product_of(u, v)), sum_of(by_number(p0, u), by_number(p1, v)));
  Interval of_u = sum_of(by_number(p0, v), by_number(3.0f * p1 + s0, u));
  Interval of_v = sum_of(by_number(3.0f * p0 + s1, v), by_number(p1, u));
  most.uu = most_of(sum_of(ratio, by_number(2.0f, sum_of(product_of(by_s, square_of(u)), of_u))));
  most.uv = 2.0f * most_of(sum_of(shared_slope, by_number(s0, v)));
  most.vu = 2.0f * most_of(sum_of(shared_slope, by_number(s1, u)));
  most.vv = most_of(sum_of(ratio, by_number(2.0f, sum_of(product_of(by_s, square_of(v)), of_v))));
  return most;
}

FUNCTION float middle_of(Interval a) { return 0.5f * (a.low + a.high); }
FUNCTION float half_of(Interval a) { return 1.00001f * max(a.high - middle_of(a), middle_of(a) - a.low); }

// Moves a box by the distortion, by the mean value theorem.
FUNCTION LensBox distorted_box(Eye eye, PlaneBox box) {
  Distorted middle = distort(eye, pair(middle_of(box.u), 0.0f), pair(middle_of(box.v), 0.0f));
  MostDistorted most = most_distorted(eye, box);
  LensBox seen = unbounded(true);
  seen.u = middle.u.high;
  seen.v = middle.v.high;
  seen.half_u = most.uu * half_of(box.u) + most.uv * half_of(box.v);
  seen.half_v = most.vu * half_of(box.u) + most.vv * half_of(box.v);
  return seen;
}

// x / z for z > 0
FUNCTION Interval tangents_of(Interval x, Interval z) {
  return interval(x.low / (x.low < 0.0f ? z.low : z.high), x.high / (x.high < 0.0f ? z.high : z.low));
}
FUNCTION Interval within_limits(Interval t, FloatPair least, FloatPair most) {
  return interval(min(max(t.low, least.high), most.high), min(max(t.high, least.high), most.high));
}

FUNCTION Interval along_axis(CameraBox box, uint k) {
  return interval(box.centre[k] - box.extent[k], box.centre[k] + box.extent[k]);
}

FUNCTION LensBox box_through_perspective(Eye eye, CameraBox box) {
  Interval z = along_axis(box, 2u);
  if (!(z.low > 0.0f)) return unbounded(!(z.high <= 0.0f));
  PlaneBox place;
  place.u = tangents_of(along_axis(box, 0u), z);
  place.v = tangents_of(along_axis(box, 1u), z);
  if (!(most_of(radius_squared(place)) < 1e6f)) return unbounded(true);
  LensBox seen = distorted_box(eye, place);
  float fold = eye.fold_squared.high;
  seen.inside = !(radius_squared(place).low >= 1.00001f * fold);
  // Derivatives are those at tangents within the limits, or at the place where these are beyond the fold.
  PlaneBox at;
  at.u = within_limits(place.u, eye.least_u, eye.most_u);
  at.v = within_limits(place.v, eye.least_v, eye.most_v);
  if (!(1.00001f * radius_squared(at).high < fold)) {
    at.u = hull_of(at.u, place.u);
    at.v = hull_of(at.v, place.v);
  }
  MostDistorted most = most_distorted(eye, at);
  float u = sqrt(1.0f + square_of(at.u).high) / z.low, v = sqrt(1.0f + square_of(at.v).high) / z.low;
  seen.du = most.uu * u + most.uv * v;
  seen.dv = most.vu * u + most.vv * v;
  seen.bounded = true;
  return seen;
}

// The directions of a box, seen from the camera, are within an angle of that of its centre.
struct Cone {
  float distance, radius, nearest;  // of the centre; of the box, from there and from the camera
  float along;                      // from the camera to where the cone touches the sphere around the box
  float half_angle;
  bool narrow;
};
FUNCTION Cone cone_of(vec3 centre, vec3 extent) {
  Cone cone;
  cone.distance = sqrt(centre.x * centre.x + centre.y * centre.y + centre.z * centre.z);
  cone.radius = 1.00001f * sqrt(extent.x * extent.x + extent.y * extent.y + extent.z * extent.z);
  cone.nearest = 0.99999f * cone.distance - cone.radius;
  cone.narrow = cone.nearest > 1e-3f * cone.distance;
  cone.along = 0.0f;
  cone.half_angle = 0.0f;
  if (cone.narrow) {
    cone.along = sqrt(cone.nearest * (cone.distance + cone.radius));
    cone.half_angle = 1e-6f + 1.00001f * angle_of(pair(cone.radius, 0.0f), pair(cone.along, 0.0f)).high;
  }
  return cone;
}

// A step of the direction moves the point of the plane by angle / sin(angle) times it at most.
FUNCTION LensBox box_through_fisheye(Eye eye, CameraBox box) {
  Cone cone = cone_of(box.centre, box.extent);
  if (!cone.narrow) return unbounded(true);
  vec3 c = box.centre;
  float across = sqrt(c.x * c.x + c.y * c.y), angle = angle_of(pair(across, 0.0f), pair(c.z, 0.0f)).high;
  float nearest = angle - cone.half_angle, furthest = angle + cone.half_angle;
  bool inside = !(nearest > 0.0f && 0.99999f * nearest * nearest >= eye.fold_squared.high);
  // The sine of the furthest angle, at least.
  float sine = (across * cone.along + c.z * cone.radius) / (cone.distance * cone.distance) - 2e-5f;
  if (!(furthest < 3.14f) || (furthest > 0.05f && !(sine > 0.0f))) return unbounded(inside);
  float stretch = furthest > 0.05f ? furthest / sine : 1.001f, half_angle = cone.half_angle * stretch;
  float u = 0.0f, v = 0.0f;
  if (across > 0.0f) {
    u = angle * c.x / across;
    v = angle * c.y / across;
  }
  PlaneBox place;
  place.u = interval(u - half_angle, u + half_angle);
  place.v = interval(v - half_angle, v + half_angle);
  LensBox seen = distorted_box(eye, place);
  MostDistorted most = most_distorted(eye, place);
  seen.du = (most.uu + most.uv) * stretch / cone.nearest;
  seen.dv = (most.vu + most.vv) * stretch / cone.nearest;
  seen.inside = inside;
  seen.bounded = true;
  return seen;
}

// Azimuths as a cone seen from above has them.
FUNCTION LensBox box_through_equirectangular(CameraBox box) {
  vec3 c = box.centre;
  Cone cone = cone_of(c, box.extent), level = cone_of(vec3(c.x, 0.0f, c.z), vec3(box.extent.x, 0.0f, box.extent.z));
  LensBox seen = unbounded(true);
  if (!cone.narrow || !level.narrow) return seen;
  seen.u = angle_of(pair(c.x, 0.0f), pair(c.z, 0.0f)).high;
  seen.v = angle_of(pair(c.y, 0.0f), pair(level.distance, 0.0f)).high;
  seen.half_u = level.half_angle;
  seen.half_v = cone.half_angle;
  seen.du = 1.00001f / level.nearest;
  seen.dv = 1.00001f / cone.nearest;
  seen.bounded = true;
  return seen;
}

FUNCTION LensBox box_through(uint lens, Eye eye, CameraBox box) {
  if (lens == perspective) return box_through_perspective(eye, box);
  if (lens == fisheye) return box_through_fisheye(eye, box);
  if (lens == equirectangular) return box_through_equirectangular(box);
  LensBox seen = unbounded(true);
  seen.u = box.centre.x;
  seen.v = box.centre.y;
  seen.half_u = box.extent.x;
  seen.half_v = box.extent.y;
  seen.du = seen.dv = 1.0f;
  seen.bounded = true;
  return seen;
}
