// SPDX-License-Identifier: Apache-2.0

// Views through any lens as swiftgs/lens/formulas.inc and swiftgs/plane/attributes.hpp have them, with pairs of floats in
// place of doubles. tests/vulkan compiles this file as C++.

// The order of `LensModel`. A pinhole that takes z alone is none of them.
const uint perspective = 0u, fisheye = 1u, orthographic = 2u, equirectangular = 3u, pinhole = 4u;

// Pi, half of it, and the inverse tangents of eighths.
FUNCTION FloatPair whole_pi() { return pair(3.14159274f, -8.74227766e-08f); }
FUNCTION FloatPair half_pi() { return pair(1.57079637f, -4.37113883e-08f); }
FUNCTION FloatPair angle_of_eighths(uint eighths) {
  if (eighths == 1u) return pair(0.124354996f, -1.24038224e-09f);
  if (eighths == 2u) return pair(0.244978666f, -3.17867777e-09f);
  if (eighths == 3u) return pair(0.358770669f, 1.76394988e-09f);
  if (eighths == 4u) return pair(0.463647604f, 5.01215869e-09f);
  if (eighths == 5u) return pair(0.558599293f, 2.21115979e-08f);
  if (eighths == 6u) return pair(0.643501103f, 5.86893734e-09f);
  if (eighths == 7u) return pair(0.718829989f, 1.01883355e-08f);
  if (eighths == 8u) return pair(0.785398185f, -2.18556941e-08f);
  return pair(0.0f, 0.0f);
}

// atan2(y, x), off by 4e-11: the angle of the nearest eighth, and the series of the rest.
FUNCTION FloatPair angle_of(FloatPair y, FloatPair x) {
  FloatPair up = y, right = x;
  if (y.high < 0.0f) up = negative(y);
  if (x.high < 0.0f) right = negative(x);
  bool steep = is_less(right, up);
  FloatPair larger = steep ? up : right, smaller = steep ? right : up;
  if (!(larger.high > 0.0f)) return pair(0.0f, 0.0f);
  FloatPair ratio = times(smaller, inverse_pair(larger));
  float eighths = roundEven(8.0f * ratio.high);
  FloatPair near = pair(0.125f * eighths, 0.0f);
  FloatPair t = times(subtract(ratio, near), inverse_pair(multiply_add(ratio, near, pair(1.0f, 0.0f))));
  PRECISE float s = t.high * t.high;
  PRECISE float p3 = s * -0.142857149f + 0.2f;
  PRECISE float p2 = s * p3 - 0.333333343f;
  PRECISE float cube = t.high * s;
  PRECISE float rest = cube * p2;
  FloatPair angle = add(angle_of_eighths(uint(eighths)), add(t, pair(rest, 0.0f)));
  if (steep) angle = subtract(half_pi(), angle);
  if (x.high < 0.0f) angle = subtract(whole_pi(), angle);
  return y.high < 0.0f ? negative(angle) : angle;
}

// A power of two that brings the largest part of p to 1 or more, below 2.
FUNCTION float scale_of(PairVector p) {
  float largest = max(max(abs(p.x.high), abs(p.y.high)), abs(p.z.high));
  uint exponent = floatBitsToUint(largest) & 0x7f800000u;
  return uintBitsToFloat(exponent < 0x01000000u ? 0x7e000000u : exponent > 0x7e000000u ? 0x00800000u : 0x7f000000u - exponent);
}

FUNCTION FloatPair length_of(PairVector p) {
  float scale = scale_of(p);
  PairVector near_one = scaled(p, pair(scale, 0.0f));
  FloatPair squared = dot_pairs(near_one, near_one);
  return times(times(squared, inverse_root(squared)), pair(1.0f / scale, 0.0f));
}

FUNCTION float depth_of(Eye eye, PairVector p) {
  if (eye.depth_is_distance != 0u) return times(eye.depth_scale, length_of(p)).high;
  return times(eye.depth_scale, p.z).high;
}

// As `DistortedOf`.
struct Distorted {
  FloatPair u, v, uu, uv, vu, vv;
};

// 1 + c0 s + c1 s^2 + ..., and its derivative.
struct Polynomial {
  FloatPair value, slope;
};
FUNCTION Polynomial polynomial(FloatPair c0, FloatPair c1, FloatPair c2, FloatPair c3, FloatPair s) {
  Polynomial p;
  p.slope = c3;
  p.value = multiply_add(c3, s, c2);
  p.slope = multiply_add(p.slope, s, p.value);
  p.value = multiply_add(p.value, s, c1);
  p.slope = multiply_add(p.slope, s, p.value);
  p.value = multiply_add(p.value, s, c0);
  p.slope = multiply_add(p.slope, s, p.value);
  p.value = multiply_add(p.value, s, pair(1.0f, 0.0f));
  return p;
}

FUNCTION FloatPair twice(FloatPair a) { return pair(2.0f * a.high, 2.0f * a.low); }

FUNCTION Distorted distort(Eye eye, FloatPair u, FloatPair v) {
  FloatPair s = multiply_add(u, u, times(v, v));
  Polynomial above = polynomial(eye.radial[0], eye.radial[1], eye.radial[2], eye.radial[3], s);
  Polynomial below = polynomial(eye.rational[0], eye.rational[1], eye.rational[2], pair(0.0f, 0.0f), s);
  FloatPair inverse_below = inverse_pair(below.value), ratio = times(above.value, inverse_below);
  FloatPair by_s = times(multiply_add(negative(ratio), below.slope, above.slope), inverse_below);
  FloatPair p0 = eye.tangential[0], p1 = eye.tangential[1], s0 = eye.prism[0], s1 = eye.prism[1];
  FloatPair uv = twice(times(u, v)), two_uu = twice(times(u, u)), two_vv = twice(times(v, v));
  FloatPair cross_slope = multiply_add(by_s, uv, twice(multiply_add(p0, u, times(p1, v))));
  FloatPair three = pair(3.0f, 0.0f);
  Distorted d;
  d.u = multiply_add(u, ratio, multiply_add(p0, uv, multiply_add(p1, add(two_uu, s), times(s0, s))));
  d.v = multiply_add(v, ratio, multiply_add(p1, uv, multiply_add(p0, add(two_vv, s), times(s1, s))));
  d.uu = add(twice(multiply_add(times(by_s, u), u, multiply_add(p0, v, times(multiply_add(three, p1, s0), u)))), ratio);
  d.uv = multiply_add(twice(s0), v, cross_slope);
  d.vu = multiply_add(twice(s1), u, cross_slope);
  d.vv = add(twice(multiply_add(times(by_s, v), v, multiply_add(p1, u, times(multiply_add(three, p0, s1), v)))), ratio);
  return d;
}

FUNCTION bool keeps_sides(Distorted at) {
  return minor_of(at.uu, at.vv, at.uv, at.vu).high > 0.0f && add(at.uu, at.vv).high > 0.0f;
}

// As `LensPoint`.
struct LensPoint {
  FloatPair u, v;
  PairVector du, dv;
  bool inside;
};

FUNCTION LensPoint through_perspective(Eye eye, PairVector p) {
  FloatPair inverse_z = inverse_pair(p.z), u = times(p.x, inverse_z), v = times(p.y, inverse_z);
  Distorted place = distort(eye, u, v);
  FloatPair at_u = clamped(u, eye.least_u, eye.most_u), at_v = clamped(v, eye.least_v, eye.most_v);
  if (!is_less(multiply_add(at_u, at_u, times(at_v, at_v)), eye.fold_squared)) {  // a corner of the limits
    at_u = u;
    at_v = v;
  }
  Distorted by = distort(eye, at_u, at_v);
  FloatPair back_u = negative(times(inverse_z, at_u)), back_v = negative(times(inverse_z, at_v));
  LensPoint seen;
  seen.u = place.u;
  seen.v = place.v;
  seen.du = pair_vector(times(by.uu, inverse_z), times(by.uv, inverse_z), multiply_add(by.uu, back_u, times(by.uv, back_v)));
  seen.dv = pair_vector(times(by.vu, inverse_z), times(by.vv, inverse_z), multiply_add(by.vu, back_u, times(by.vv, back_v)));
  seen.inside = p.z.high > 0.0f && is_less(multiply_add(u, u, times(v, v)), eye.fold_squared) && keeps_sides(place);
  return seen;
}

// The square of what cannot be told from 0, beside 1.
FUNCTION float least_squared() { return 1e-36f; }

FUNCTION LensPoint through_fisheye(Eye eye, PairVector p) {
  FloatPair none = pair(0.0f, 0.0f), across_squared = multiply_add(p.x, p.x, times(p.y, p.y));
  bool on_axis = !(across_squared.high >= least_squared());
  FloatPair across = none, x = pair(1.0f, 0.0f), y = none, inverse_across = none;
  if (!on_axis) {
    inverse_across = inverse_root(across_squared);
    across = times(across_squared, inverse_across);
    x = times(p.x, inverse_across);
    y = times(p.y, inverse_across);
  }
  FloatPair polar = angle_of(across, p.z);
  // The plane moves by `outward` with a step away from the axis, by `around` with one about it.
  FloatPair inverse_squared = inverse_pair(multiply_add(p.z, p.z, across_squared)), outward = times(p.z, inverse_squared);
  FloatPair around = outward;
  if (!on_axis) around = times(polar, inverse_across);
  FloatPair mixed = times(times(x, y), subtract(outward, around)), xx = times(x, x), yy = times(y, y);
  PairVector du = pair_vector(multiply_add(xx, outward, times(yy, around)), mixed, negative(times(p.x, inverse_squared)));
  PairVector dv = pair_vector(mixed, multiply_add(yy, outward, times(xx, around)), negative(times(p.y, inverse_squared)));
  Distorted by = distort(eye, times(polar, x), times(polar, y));
  LensPoint seen;
  seen.u = by.u;
  seen.v = by.v;
  seen.du = along(scaled(dv, by.uv), by.uu, du);
  seen.dv = along(scaled(dv, by.vv), by.vu, du);
  seen.inside = is_less(times(polar, polar), eye.fold_squared) && keeps_sides(by);
  return seen;
}

FUNCTION LensPoint through_equirectangular(Eye eye, PairVector p) {
  FloatPair none = pair(0.0f, 0.0f), level_squared = multiply_add(p.x, p.x, times(p.z, p.z));
  FloatPair over_level = inverse_root(level_squared), level = times(level_squared, over_level);
  FloatPair over_distance = inverse_root(multiply_add(p.y, p.y, level_squared));
  FloatPair over_squared = times(over_distance, over_distance), most = times(over_distance, eye.most_cosecant);
  FloatPair over_radius = most;
  if (is_less(over_level, most)) over_radius = over_level;
  FloatPair x = times(p.x, over_level), z = times(p.z, over_level);  // where the azimuth points
  FloatPair down = negative(times(p.y, over_squared));
  LensPoint seen;
  seen.u = angle_of(p.x, p.z);
  seen.v = angle_of(p.y, level);
  seen.du = pair_vector(times(z, over_radius), none, negative(times(x, over_radius)));
  seen.dv = pair_vector(times(down, x), times(level, over_squared), times(down, z));
  seen.inside = level_squared.high > least_squared();  // a pole has every azimuth
  return seen;
}

// Where the lens shows p. Angles and tangents do not change with the scale of p, which is brought near 1.
FUNCTION LensPoint point_through(uint lens, Eye eye, PairVector p) {
  LensPoint seen;
  if (lens == orthographic) {
    FloatPair none = pair(0.0f, 0.0f), one = pair(1.0f, 0.0f);
    seen.u = p.x;
    seen.v = p.y;
    seen.du = pair_vector(one, none, none);
    seen.dv = pair_vector(none, one, none);
    seen.inside = true;
    return seen;
  }
  FloatPair scale = pair(scale_of(p), 0.0f);
  PairVector near_one = scaled(p, scale);
  if (lens == perspective) seen = through_perspective(eye, near_one);
  else if (lens == fisheye) seen = through_fisheye(eye, near_one);
  else seen = through_equirectangular(eye, near_one);
  seen.du = scaled(seen.du, scale);
  seen.dv = scaled(seen.dv, scale);
  return seen;
}

FUNCTION PairVector in_scene(Eye eye, PairVector d) {
  return along(along(scaled(eye_axis(eye, 2u), d.z), d.y, eye_axis(eye, 1u)), d.x, eye_axis(eye, 0u));
}
FUNCTION ImageRows lens_rows(Eye eye, LensPoint at, Gaussian g) {
  LocalAxes axes = local_axes(g.rotation);
  ImageRows rows;
  rows.x = image_row(in_scene(eye, at.du), eye.fx, g.scale, axes);
  rows.y = image_row(in_scene(eye, at.dv), eye.fy, g.scale, axes);
  return rows;
}

// As `ViewConstants::nearest_copy`.
FUNCTION FloatPair nearest_copy(Eye eye, FloatPair x) {
  if (eye.turn.high == 0.0f) return x;
  float turns = times(subtract(x, eye.panorama_middle), inverse_pair(eye.turn)).high;
  float whole = floor(abs(turns) + 0.5f);
  return multiply_add(eye.turn, pair(turns < 0.0f ? whole : -whole, 0.0f), x);
}

FUNCTION ProjectedShape project_through_lens(uint lens, Eye eye, Gaussian g) {
  ProjectedShape nothing;
  nothing.visible = false;
  float opacity = eye.opacity * g.opacity;
  if (!is_opaque_enough(eye, opacity)) return nothing;
  PairVector p = to_camera(eye, g.mean);
  float depth = depth_of(eye, p);
  if (!is_between_planes(eye, depth)) return nothing;
  LensPoint at = point_through(lens, eye, p);
  if (!at.inside) return nothing;
  ImageRows rows = lens_rows(eye, at, g);
  float order = depth;
  if (eye.order_is_distance != 0u) order = times(eye.depth_scale, length_of(p)).high;
  return visible_shape(eye, nearest_copy(eye, multiply_add(eye.fx, at.u, eye.cx)), multiply_add(eye.fy, at.v, eye.cy),
                       factor_of(rows.x, rows.y, eye.blur), opacity, order);
}

// As `drawn_depth`.
FUNCTION float drawn_depth(Eye eye, vec3 mean, float order) {
  return eye.order_is_distance != 0u ? depth_of(eye, to_camera(eye, mean)) : order;
}

FUNCTION PairVector cross_pairs(PairVector a, PairVector b) {
  return pair_vector(minor_of(a.y, b.z, a.z, b.y), minor_of(a.z, b.x, a.x, b.z), minor_of(a.x, b.y, a.y, b.x));
}

// As `RayDepth`: the depth in the middle of the image, and its slopes by x and y.
FUNCTION vec3 ray_depth(Eye eye, Gaussian g, Shape s, float depth, float most_squared) {
  PairVector p = to_camera(eye, g.mean), ahead = scaled(eye_axis(eye, 2u), eye.depth_scale);
  ImageRows rows;
  if (eye.lens == pinhole) rows = pinhole_rows(eye, p, g);
  else rows = lens_rows(eye, point_through(eye.lens, eye, p), g);
  if (eye.depth_is_distance != 0u)
    ahead = scaled(in_scene(eye, p), times(eye.depth_scale, inverse_pair(length_of(p))));
  PairVector d = image_row(ahead, pair(1.0f, 0.0f), g.scale, local_axes(g.rotation));

  // Rows are divided by deviations before they are squared, so that no square leaves the range of float.
  FloatPair blur = pair(eye.blur, 0.0f), ww = dot_pairs(rows.y, rows.y);
  FloatPair over_u = inverse_root(add(dot_pairs(rows.x, rows.x), blur)), over_w = inverse_root(add(ww, blur));
  PairVector u = scaled(rows.x, over_u), w = scaled(rows.y, over_w), across = cross_pairs(u, w);
  FloatPair blur_u = times(blur, times(over_u, over_u)), blur_w = times(blur, times(over_w, over_w));
  FloatPair inverse_determinant =
      inverse_pair(add(dot_pairs(across, across), add(blur_w, times(blur_u, dot_pairs(w, w)))));
  FloatPair of_x = multiply_add(blur_w, dot_pairs(u, d), dot_pairs(across, cross_pairs(d, w)));
  FloatPair of_y = multiply_add(blur_u, dot_pairs(w, d), dot_pairs(across, cross_pairs(u, d)));
  FloatPair x = times(times(over_u, of_x), inverse_determinant), y = times(times(over_w, of_y), inverse_determinant);
  vec2 low = low_of_mean(s);
  FloatPair right = add(two_sum(s.mean.x, -0.5f * eye.width), pair(low.x, 0.0f));
  FloatPair down = add(two_sum(s.mean.y, -0.5f * eye.height), pair(low.y, 0.0f));
  FloatPair middle = subtract(pair(depth, 0.0f), multiply_add(x, right, times(y, down)));
  float most = abs(middle.high) + abs(x.high) * eye.width + abs(y.high) * eye.height;
  if (!(most <= root(most_squared))) return vec3(depth, 0.0f, 0.0f);
  return vec3(middle.high, x.high, y.high);
}
