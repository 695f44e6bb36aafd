// SPDX-License-Identifier: Apache-2.0

// `AxisSharedThreshold<Diamond>` of the tests.
Terms own_terms(Shape s, vec2 first, float alpha_max) {
  const float x = right_of_mean(s, first.x), y = below_mean(s, first.y);
  return Terms(vec4(s.l0, s.l1, s.l2, fma(s.l0, x, s.l1 * y)), vec4(s.l2 * y, log2(s.opacity / alpha_max), 0.0, s.cutoff));
}
// Terms of zeros would show.
float own_alpha(Terms t, vec2 at, float least) {
  const vec4 e = t.exponent;
  const float around = abs(fma(e.x, at.x, fma(e.y, at.y, e.w))) + abs(fma(e.z, at.y, t.rest.x));
  const float exponent = around * around;
  return exponent <= t.rest.w ? min(exp2_negative(exponent - t.rest.y), 1.0) : 0.0;
}
