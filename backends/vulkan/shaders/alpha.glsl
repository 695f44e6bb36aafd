// SPDX-License-Identifier: Apache-2.0

// How pixels compute alpha and transmittance.

// The exponent representation, and whether pixels compare the exponent with the splat's cutoff.
const uint half_split = 0u, float_split = 1u, float_cholesky = 2u;
layout(constant_id = 3) const uint EXPONENT = float_cholesky;
layout(constant_id = 4) const bool THRESHOLD = true;

// 2^-s for s >= 0, a unit in the last place, by the series of the remainder of an integer.
float exp2_negative(float s) {
  const float whole = roundEven(s);
  if (!(whole <= 126.0)) return 0.0;
  precise float x = whole - s;
  precise float p6 = x * 1.540353039e-4;
  precise float p5 = p6 + 1.333355815e-3;
  precise float t5 = x * p5;
  precise float p4 = t5 + 9.618129108e-3;
  precise float t4 = x * p4;
  precise float p3 = t4 + 5.550410866e-2;
  precise float t3 = x * p3;
  precise float p2 = t3 + 2.402265070e-1;
  precise float t2 = x * p2;
  precise float p1 = t2 + 6.931471806e-1;
  precise float t1 = x * p1;
  precise float p0 = t1 + 1.0;
  return p0 * uintBitsToFloat((127u - uint(whole)) << 23);
}

// Terms of `FloatSplit`, measured from the centre of the raster block.
struct Split {
  float a, b, c, d, e, g;
};
Split split_of(Shape s, vec2 centre) {
  precise float x = right_of_mean(s, centre.x);
  precise float y = below_mean(s, centre.y);
  precise float u = s.l0 * x + s.l1 * y;
  precise float v = s.l2 * y;
  precise float a = s.l0 * s.l0;
  precise float b = 2.0 * s.l0 * s.l1;
  precise float c = s.l1 * s.l1 + s.l2 * s.l2;
  precise float d = 2.0 * s.l0 * u;
  precise float e = 2.0 * (s.l1 * u + s.l2 * v);
  precise float g = u * u + v * v;
  return Split(a, b, c, d, e, g);
}

float exponent_of(Shape s, Split split, vec2 centre, vec2 at) {
  if (EXPONENT == float_split) {
    const float x = at.x - centre.x, y = at.y - centre.y;
    precise float of_x = (split.a * x + split.d) * x;
    precise float of_y = (split.c * y + split.e) * y + split.g;
    precise float mixed = split.b * x;
    precise float exponent = of_x + of_y + mixed * y;
    return exponent < 0.0 ? 0.0 : exponent;
  }
  const float dx = right_of_mean(s, at.x), dy = below_mean(s, at.y);
  if (EXPONENT == half_split) {
    precise float of_x = s.l0 * s.l0 * dx * dx;
    precise float mixed = 2.0 * s.l0 * s.l1 * dx;
    precise float of_y = (s.l1 * s.l1 + s.l2 * s.l2) * dy * dy;
    precise float exponent = from_half(to_half(of_x)) + from_half(to_half(of_y)) +
                             from_half(to_half(mixed)) * from_half(to_half(dy));
    return exponent;
  }
  precise float p = s.l0 * dx;
  precise float q = s.l1 * dy;
  precise float u = p + q;
  precise float v = s.l2 * dy;
  precise float uu = u * u;
  precise float vv = v * v;
  precise float exponent = uu + vv;
  return exponent;
}

// 0 where the pixel skips the splat.
float alpha_of(Shape s, float exponent, RasterView view) {
  if (!(exponent >= 0.0) || (THRESHOLD && !(exponent <= s.cutoff))) return 0.0;
  precise float alpha = s.opacity * exp2_negative(exponent);
  if (!THRESHOLD && !(alpha >= view.alpha_min)) return 0.0;
  return min(alpha, view.alpha_max);
}

float dimmed(float transmittance, float alpha) {
  precise float left = 1.0 - alpha;
  precise float by_rest = transmittance * left;
  precise float taken = alpha * transmittance;
  precise float by_taken = transmittance - taken;
  return alpha > 0.5 ? by_rest : by_taken;
}
