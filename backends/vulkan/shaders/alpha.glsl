// SPDX-License-Identifier: Apache-2.0

// How pixels compute alpha and transmittance.

// The exponent representation, and whether pixels compare the exponent with the splat's cutoff.
const uint half_split = 0u, float_split = 1u, float_cholesky = 2u;
layout(constant_id = 3) const uint EXPONENT = float_cholesky;
layout(constant_id = 4) const bool THRESHOLD = true;

// A splat as pixels of a block evaluate it, measured from the block's first pixel centre.
struct Terms {
  vec4 exponent;
  vec4 rest;  // a term, the opacity, the cutoff, a term
};

Terms terms_of(Shape s, vec2 first) {
  const float x = right_of_mean(s, first.x), y = below_mean(s, first.y);
  const float u = fma(s.l0, x, s.l1 * y), v = s.l2 * y;
  if (EXPONENT == float_cholesky) return Terms(vec4(s.l0, s.l1, s.l2, u), vec4(v, s.opacity, s.cutoff, 0.0));
  const vec3 squares = vec3(s.l0 * s.l0, 2.0 * s.l0 * s.l1, fma(s.l1, s.l1, s.l2 * s.l2));
  if (EXPONENT == half_split) return Terms(vec4(squares, x), vec4(y, s.opacity, s.cutoff, 0.0));
  return Terms(vec4(squares, 2.0 * s.l0 * u), vec4(2.0 * fma(s.l1, u, s.l2 * v), s.opacity, s.cutoff, fma(u, u, v * v)));
}

// `at` is measured from the first pixel too.
float exponent_of(Terms t, vec2 at) {
  const vec4 e = t.exponent;
  if (EXPONENT == float_cholesky) {
    const float u = fma(e.x, at.x, fma(e.y, at.y, e.w)), v = fma(e.z, at.y, t.rest.x);
    return fma(u, u, v * v);
  }
  if (EXPONENT == float_split) {
    const float mixed = fma(e.y, at.y, e.w), row = fma(at.y, fma(e.z, at.y, t.rest.x), t.rest.w);
    const float exponent = fma(at.x, fma(e.x, at.x, mixed), row);
    return exponent < 0.0 ? 0.0 : exponent;  // rounding; NaN stays
  }
  const float x = at.x + e.w, y = at.y + t.rest.x;
  return from_half(to_half(e.x * x * x)) + from_half(to_half(e.z * y * y)) +
         from_half(to_half(e.y * x)) * from_half(to_half(y));
}

// 0 where the pixel skips the splat.
float alpha_of(Terms t, vec2 at, float alpha_min, float alpha_max) {
  const float exponent = exponent_of(t, at);
  const float alpha = t.rest.y * (NATIVE_EXP2 ? exp2(-exponent) : exp2_negative(exponent));
  const bool kept = THRESHOLD ? exponent <= t.rest.z : alpha >= alpha_min;
  return kept && (EXPONENT != half_split || exponent >= 0.0) ? min(alpha, alpha_max) : 0.0;
}

// The transmittance behind a splat of this alpha and weight.
float dimmed(float transmittance, float alpha, float weight) {
  if (FUSES) return fma(-alpha, transmittance, transmittance);
  precise float left = 1.0 - alpha;
  precise float by_rest = transmittance * left;
  precise float by_weight = transmittance - weight;
  return alpha > 0.5 ? by_rest : by_weight;
}
