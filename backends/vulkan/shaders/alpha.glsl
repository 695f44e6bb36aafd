// SPDX-License-Identifier: Apache-2.0

// How pixels compute alpha, in units of alpha_max, and transmittance: in this unit alpha is cut to 0 and 1, which devices do
// in the instruction that computes it.

// NClamp: `least` for NaN.
spirv_instruction(set = "GLSL.std.450", id = 81) float clamp_number(float x, float least, float most);

// The exponent representation, and whether pixels compare the exponent with the splat's cutoff.
const uint half_split = 0u, float_split = 1u, float_cholesky = 2u;
layout(constant_id = 3) const uint EXPONENT = float_cholesky;
layout(constant_id = 4) const bool THRESHOLD = true;

// A splat as pixels of a block evaluate it, measured from the block's first pixel centre.
struct Terms {
  vec4 exponent;
  vec4 rest;  // a term, the opacity, the cutoff, a term
};
// Terms that show nothing.
Terms no_terms() { return Terms(vec4(0.0), vec4(0.0, 0.0, -1.0, 0.0)); }

Terms terms_of(Shape s, vec2 first, float alpha_max) {
  const float x = right_of_mean(s, first.x), y = below_mean(s, first.y);
  const float opacity = min(s.opacity / alpha_max, 3.402823e38);
  const float u = fma(s.l0, x, s.l1 * y), v = s.l2 * y;
  if (EXPONENT == float_cholesky) return Terms(vec4(s.l0, s.l1, s.l2, u), vec4(v, opacity, s.cutoff, 0.0));
  const vec3 squares = vec3(s.l0 * s.l0, 2.0 * s.l0 * s.l1, fma(s.l1, s.l1, s.l2 * s.l2));
  if (EXPONENT == half_split) return Terms(vec4(squares, x), vec4(y, opacity, s.cutoff, 0.0));
  return Terms(vec4(squares, 2.0 * s.l0 * u), vec4(2.0 * fma(s.l1, u, s.l2 * v), opacity, s.cutoff, fma(u, u, v * v)));
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
  precise float squares = from_half(to_half(e.x * x * x)) + from_half(to_half(e.z * y * y));
  precise float mixed = from_half(to_half(e.y * x)) * from_half(to_half(y));
  precise float exponent = squares + mixed;
  return exponent;
}

// 0 where the pixel skips the splat. `least` is alpha_min in this unit.
float alpha_of(Terms t, vec2 at, float least) {
  const float exponent = exponent_of(t, at);
  const float alpha = t.rest.y * (NATIVE_EXP2 ? exp2(-exponent) : exp2_negative(exponent));
  const bool kept = (THRESHOLD ? exponent <= t.rest.z : alpha >= least) && (EXPONENT != half_split || exponent >= 0.0);
  return clamp_number(alpha * (kept ? 1.0 : 0.0), 0.0, 1.0);
}

// Whether `rest` has its last term; a rasterizer of a program's own, in place of the functions above, has it.
#ifdef OWN_RASTERIZER
#include "policy.glsl"
#define terms_of own_terms
#define alpha_of own_alpha
#define HAS_LAST_TERM true
#else
#define HAS_LAST_TERM (EXPONENT == float_split)
#endif

// The transmittance behind a splat of this alpha and weight.
float dimmed(float transmittance, float alpha, float weight, float alpha_max) {
  if (FUSES) return fma(-alpha_max, weight, transmittance);
  precise float whole = alpha_max * alpha;
  precise float left = 1.0 - whole;
  precise float by_rest = transmittance * left;
  precise float of_weight = alpha_max * weight;
  precise float by_weight = transmittance - of_weight;
  return whole > 0.5 ? by_rest : by_weight;
}
