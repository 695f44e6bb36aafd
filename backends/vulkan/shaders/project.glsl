// SPDX-License-Identifier: Apache-2.0

// Projection through a pinhole as swiftgs/project/project.hpp has it, with pairs of floats in place of doubles: means,
// factors and cutoffs are rounded once, when a splat is stored. tests/vulkan compiles this file as C++.

// What a frame knows of a view and a placed scene that it shows: `ViewConstants` of its eye.
struct Eye {
  FloatPair rotation[9];  // rows
  FloatPair centre[3];
  FloatPair fx, fy, cx, cy, depth_scale;
  FloatPair least_u, most_u, least_v, most_v;  // limits of tangents
  FloatPair log2_alpha_min;
  FloatPair radial[4], rational[3], tangential[2], prism[2];  // of the lens
  FloatPair fold_squared, most_cosecant;
  FloatPair turn, panorama_middle;  // of panoramas
  float blur, opacity, alpha_min, min_compensation;
  float near_plane, far_plane, width, height;
  float left, top, right, bottom;
  uint antialiased, lens, depth_is_distance, order_is_distance;
};

struct Gaussian {
  vec3 mean, scale;
  vec4 rotation;  // w, x, y, z
  float opacity;
};

// The layout of `SplatShape`.
struct Shape {
  vec2 mean;
  float l0, l1, l2, opacity, cutoff;
  uint low;
};

struct ProjectedShape {
  Shape shape;
  float depth;
  bool visible;
};

// What the mean has beyond its floats, and how it is stored: the only functions that know its encoding.
FUNCTION vec2 low_of_mean(Shape s) {
  PRECISE float x = 5.9604644775390625e-8f * float(s.low & 0xffffu);
  PRECISE float y = 5.9604644775390625e-8f * float(s.low >> 16);
  return vec2(x, y);
}
// Sets `mean` to the largest float that is not above x, and returns what it lacks.
FUNCTION uint round_down(FloatPair x, INOUT(float) mean) {
  mean = x.high;
  float lacks = x.low;
  if (lacks < 0.0f) {
    mean = uintBitsToFloat(floatBitsToUint(x.high) + (x.high > 0.0f ? 0xffffffffu : 1u));
    PRECISE float step = x.high - mean;
    PRECISE float sum = lacks + step;
    lacks = sum;
  }
  float units = 16777216.0f * lacks;
  return uint(roundEven(!(units <= 65535.0f) ? 65535.0f : units));
}
FUNCTION void set_mean(INOUT(Shape) s, FloatPair x, FloatPair y) {
  float column, row;
  s.low = round_down(x, column);
  s.low = s.low | (round_down(y, row) << 16);
  s.mean = vec2(column, row);
}

FUNCTION float right_of_mean(Shape s, float x) {
  PRECISE float from_float = x - s.mean.x;
  PRECISE float from_mean = from_float - low_of_mean(s).x;
  return from_mean;
}
FUNCTION float below_mean(Shape s, float y) {
  PRECISE float from_float = y - s.mean.y;
  PRECISE float from_mean = from_float - low_of_mean(s).y;
  return from_mean;
}

// A vector of pairs.
struct PairVector {
  FloatPair x, y, z;
};
FUNCTION PairVector pair_vector(FloatPair x, FloatPair y, FloatPair z) {
  PairVector v;
  v.x = x;
  v.y = y;
  v.z = z;
  return v;
}
FUNCTION FloatPair dot_pairs(PairVector a, PairVector b) {
  return tight(loose_sum(loose_sum(loose_product(a.x, b.x), loose_product(a.y, b.y)), loose_product(a.z, b.z)));
}
// a b - c d
FUNCTION FloatPair minor_of(FloatPair a, FloatPair b, FloatPair c, FloatPair d) {
  return multiply_add(a, b, negative(loose_product(c, d)));
}
// x + t y
FUNCTION PairVector along(PairVector x, FloatPair t, PairVector y) {
  return pair_vector(multiply_add(t, y.x, x.x), multiply_add(t, y.y, x.y), multiply_add(t, y.z, x.z));
}
FUNCTION PairVector scaled(PairVector v, FloatPair by) {
  return pair_vector(times(v.x, by), times(v.y, by), times(v.z, by));
}

FUNCTION bool is_less(FloatPair a, FloatPair b) { return a.high < b.high || (a.high == b.high && a.low < b.low); }
FUNCTION FloatPair clamped(FloatPair x, FloatPair least, FloatPair most) {
  if (is_less(x, least)) return least;
  if (is_less(most, x)) return most;
  return x;
}

// Columns of the rotation matrix of a quaternion, unit or not, in loose pairs. Doubling is exact.
struct LocalAxes {
  PairVector x, y, z;
};
FUNCTION FloatPair rest_of_one(FloatPair a, FloatPair b) {
  return loose_sum(loose_sum(pair(1.0f, 0.0f), negative(a)), negative(b));
}
FUNCTION LocalAxes local_axes(vec4 q) {
  float w = q.x, x = q.y, y = q.z, z = q.w, x2 = 2.0f * x, y2 = 2.0f * y, z2 = 2.0f * z;
  FloatPair xx = two_product(x2, x), yy = two_product(y2, y), zz = two_product(z2, z);
  FloatPair xy = two_product(x2, y), xz = two_product(x2, z), yz = two_product(y2, z);
  FloatPair wx = two_product(w, x2), wy = two_product(w, y2), wz = two_product(w, z2);
  LocalAxes axes;
  axes.x = pair_vector(rest_of_one(yy, zz), loose_sum(xy, wz), loose_sum(xz, negative(wy)));
  axes.y = pair_vector(loose_sum(xy, negative(wz)), rest_of_one(xx, zz), loose_sum(yz, wx));
  axes.z = pair_vector(loose_sum(xz, wy), loose_sum(yz, negative(wx)), rest_of_one(xx, yy));
  return axes;
}

// A row of J W R S, where `seen` is that of J W without focal lengths.
FUNCTION PairVector image_row(PairVector seen, FloatPair pixels, vec3 scale, LocalAxes axes) {
  return pair_vector(times(times(pixels, pair(scale.x, 0.0f)), dot_pairs(seen, axes.x)),
                     times(times(pixels, pair(scale.y, 0.0f)), dot_pairs(seen, axes.y)),
                     times(times(pixels, pair(scale.z, 0.0f)), dot_pairs(seen, axes.z)));
}

struct Factor {
  float l0, l1, l2, var_x, var_y, sharpness;
  bool valid;
};

// The determinant of the covariance is |x cross y|^2 + blur (trace + blur), a sum of squares.
FUNCTION Factor factor_of(PairVector mx, PairVector my, float blur) {
  FloatPair b = pair(blur, 0.0f), xx = dot_pairs(mx, mx), yy = dot_pairs(my, my), xy = dot_pairs(mx, my);
  FloatPair var_x = add(xx, b), var_y = add(yy, b);
  FloatPair inverse_sigma_y = inverse_root(var_y), inverse_var_y = times(inverse_sigma_y, inverse_sigma_y);
  PairVector narrow = scaled(pair_vector(minor_of(mx.y, my.z, mx.z, my.y), minor_of(mx.z, my.x, mx.x, my.z),
                                         minor_of(mx.x, my.y, mx.y, my.x)),
                             inverse_sigma_y);
  FloatPair sharp = dot_pairs(narrow, narrow);
  FloatPair given_y = multiply_add(b, times(add(xx, var_y), inverse_var_y), sharp);
  FloatPair to_base_2 = pair(0.849321783f, 1.769906e-08f), l0 = times(to_base_2, inverse_root(given_y));
  Factor f;
  f.l0 = l0.high;
  f.l1 = -times(l0, times(xy, inverse_var_y)).high;
  f.l2 = times(to_base_2, inverse_sigma_y).high;
  f.var_x = var_x.high;
  f.var_y = var_y.high;
  f.sharpness = times(sharp, inverse_pair(given_y)).high;
  float most = 3.4e38f;
  f.valid = given_y.high > 0.0f && given_y.high <= most && var_y.high > 0.0f && var_x.high <= 1e36f &&
            var_y.high <= 1e36f && f.l0 <= most && abs(f.l1) <= most && f.l2 <= most;
  return f;
}

// The camera's axis to the right, down or ahead.
FUNCTION PairVector eye_axis(Eye eye, uint k) {
  return pair_vector(eye.rotation[3u * k], eye.rotation[3u * k + 1u], eye.rotation[3u * k + 2u]);
}

FUNCTION PairVector to_camera(Eye eye, vec3 mean) {
  FloatPair x = float_minus(mean.x, eye.centre[0]), y = float_minus(mean.y, eye.centre[1]),
            z = float_minus(mean.z, eye.centre[2]);
  PairVector d = pair_vector(x, y, z);
  return pair_vector(dot_pairs(eye_axis(eye, 0u), d), dot_pairs(eye_axis(eye, 1u), d), dot_pairs(eye_axis(eye, 2u), d));
}

FUNCTION ProjectedShape visible_shape(Eye eye, FloatPair mean_x, FloatPair mean_y, Factor f, float opacity, float depth) {
  ProjectedShape p;
  p.visible = false;
  p.depth = depth;
  if (!f.valid) return p;
  float drawn = opacity;
  if (eye.antialiased != 0u) drawn = drawn * root(f.sharpness > eye.min_compensation ? f.sharpness : eye.min_compensation);
  if (!(drawn >= eye.alpha_min)) return p;

  Shape s;
  set_mean(s, mean_x, mean_y);
  s.l0 = f.l0;
  s.l1 = f.l1;
  s.l2 = f.l2;
  s.opacity = drawn;
  float cutoff = subtract(log2_of(drawn), eye.log2_alpha_min).high;
  s.cutoff = cutoff > 0.0f ? cutoff : 0.0f;
  p.shape = s;
  PRECISE float extent = root(s.cutoff) * 1.17741002f;
  PRECISE float half_width = extent * root(f.var_x);
  PRECISE float half_height = extent * root(f.var_y);
  PRECISE float last_x = eye.width - 0.5f;
  PRECISE float last_y = eye.height - 0.5f;
  p.visible = right_of_mean(s, 0.5f) <= half_width && -right_of_mean(s, last_x) <= half_width &&
              below_mean(s, 0.5f) <= half_height && -below_mean(s, last_y) <= half_height;
  float slack = 2.0f * (1e-2f + 1e-4f * (half_width + half_height));
  float x = half_width + slack, y = half_height + slack;
  p.visible = p.visible && s.mean.x + x >= eye.left + 0.5f && s.mean.x - x <= eye.right - 0.5f &&
              s.mean.y + y >= eye.top + 0.5f && s.mean.y - y <= eye.bottom - 0.5f;
  return p;
}

FUNCTION bool is_opaque_enough(Eye eye, float opacity) { return opacity >= eye.alpha_min && opacity <= 3.402823e38f; }
FUNCTION bool is_between_planes(Eye eye, float depth) { return depth > eye.near_plane && depth <= eye.far_plane; }

// How the image moves with a Gaussian's own unit sphere.
struct ImageRows {
  PairVector x, y;
};
// Linearised within the limits of the conventions.
FUNCTION ImageRows pinhole_rows(Eye eye, PairVector p, Gaussian g) {
  FloatPair inverse_z = inverse_pair(p.z), u = times(p.x, inverse_z), v = times(p.y, inverse_z);
  LocalAxes axes = local_axes(g.rotation);
  PairVector ahead = eye_axis(eye, 2u);
  PairVector seen_x = along(eye_axis(eye, 0u), negative(clamped(u, eye.least_u, eye.most_u)), ahead);
  PairVector seen_y = along(eye_axis(eye, 1u), negative(clamped(v, eye.least_v, eye.most_v)), ahead);
  ImageRows rows;
  rows.x = image_row(seen_x, times(eye.fx, inverse_z), g.scale, axes);
  rows.y = image_row(seen_y, times(eye.fy, inverse_z), g.scale, axes);
  return rows;
}

FUNCTION ProjectedShape project_through_pinhole(Eye eye, Gaussian g) {
  ProjectedShape nothing;
  nothing.visible = false;
  float opacity = eye.opacity * g.opacity;
  if (!is_opaque_enough(eye, opacity)) return nothing;
  PairVector p = to_camera(eye, g.mean);
  float depth = times(eye.depth_scale, p.z).high;
  if (!is_between_planes(eye, depth)) return nothing;
  FloatPair inverse_z = inverse_pair(p.z), u = times(p.x, inverse_z), v = times(p.y, inverse_z);
  ImageRows rows = pinhole_rows(eye, p, g);
  return visible_shape(eye, multiply_add(eye.fx, u, eye.cx), multiply_add(eye.fy, v, eye.cy),
                       factor_of(rows.x, rows.y, eye.blur), opacity, depth);
}

// Unit direction from the camera towards `mean`. The largest component is scaled to 1 first, so that no square leaves
// the range of float.
FUNCTION vec3 view_direction(Eye eye, vec3 mean) {
  float x = float_minus(mean.x, eye.centre[0]).high, y = float_minus(mean.y, eye.centre[1]).high,
        z = float_minus(mean.z, eye.centre[2]).high;
  float largest = max(max(abs(x), abs(y)), abs(z));
  x = x / largest;
  y = y / largest;
  z = z / largest;
  float length = inverse_root(pair(x * x + y * y + z * z, 0.0f)).high;
  return vec3(x * length, y * length, z * length);
}
