// SPDX-License-Identifier: Apache-2.0

// Arithmetic in pairs of floats as swiftgs/frame/float_pair.hpp has it: high + low, where high is the sum rounded to
// float. Products are split into halves unless FUSES, because `fma` of Vulkan may round twice. Each operation has a name of its
// own, `precise`, so that no compiler fuses or reorders. tests/vulkan compiles this file as C++.

#ifndef __cplusplus
#define FUNCTION
#define PRECISE precise
#define INOUT(T) inout T
#endif

struct FloatPair {
  float high, low;
};

FUNCTION FloatPair pair(float high, float low) {
  FloatPair p;
  p.high = high;
  p.low = low;
  return p;
}
FUNCTION FloatPair negative(FloatPair a) { return pair(-a.high, -a.low); }

// a + b, exactly, where a is 0 or |a| >= |b|.
FUNCTION FloatPair fast_two_sum(float a, float b) {
  PRECISE float sum = a + b;
  PRECISE float of_b = sum - a;
  PRECISE float low = b - of_b;
  return pair(sum, low);
}

// a + b, exactly.
FUNCTION FloatPair two_sum(float a, float b) {
  PRECISE float sum = a + b;
  PRECISE float of_a = sum - b;
  PRECISE float of_b = sum - of_a;
  PRECISE float lacks_a = a - of_a;
  PRECISE float lacks_b = b - of_b;
  PRECISE float low = lacks_a + lacks_b;
  return pair(sum, low);
}

// a b, exactly: the upper 12 bits of each factor and the others make four exact products.
FUNCTION FloatPair split_product(float a, float b) {
  PRECISE float product = a * b;
  float ah = uintBitsToFloat(floatBitsToUint(a) & 0xfffff000u);
  float bh = uintBitsToFloat(floatBitsToUint(b) & 0xfffff000u);
  PRECISE float al = a - ah;
  PRECISE float bl = b - bh;
  PRECISE float hh = ah * bh;
  PRECISE float hl = ah * bl;
  PRECISE float lh = al * bh;
  PRECISE float ll = al * bl;
  PRECISE float rest = hh - product;
  PRECISE float with_hl = rest + hl;
  PRECISE float with_lh = with_hl + lh;
  PRECISE float low = with_lh + ll;
  return pair(product, low);
}

FUNCTION FloatPair two_product(float a, float b) {
  if (!FUSES) return split_product(a, b);
  PRECISE float product = a * b;
  PRECISE float low = fma(a, b, -product);
  return pair(product, low);
}

// Off by 3 u^2 (|a| + |b|), with u = 2^-24.
FUNCTION FloatPair add(FloatPair a, FloatPair b) {
  FloatPair high = two_sum(a.high, b.high);
  FloatPair low = two_sum(a.low, b.low);
  PRECISE float across = high.low + low.high;
  FloatPair sum = fast_two_sum(high.high, across);
  PRECISE float rest = low.low + sum.low;
  return fast_two_sum(sum.high, rest);
}
FUNCTION FloatPair subtract(FloatPair a, FloatPair b) { return add(a, negative(b)); }

// a - b, off by 2 u^2 |a - b|.
FUNCTION FloatPair float_minus(float a, FloatPair b) {
  FloatPair sum = two_sum(a, -b.high);
  PRECISE float low = sum.low - b.low;
  return fast_two_sum(sum.high, low);
}

FUNCTION FloatPair unnormalised_product(FloatPair a, FloatPair b) {
  FloatPair product = two_product(a.high, b.high);
  PRECISE float high_low = a.high * b.low;
  PRECISE float low_high = a.low * b.high;
  PRECISE float across = high_low + low_high;
  PRECISE float low = product.low + across;
  return pair(product.high, low);
}

// Off by 7 u^2 |a b|.
FUNCTION FloatPair times(FloatPair a, FloatPair b) {
  FloatPair product = unnormalised_product(a, b);
  return fast_two_sum(product.high, product.low);
}

// a b + c.
FUNCTION FloatPair multiply_add(FloatPair a, FloatPair b, FloatPair c) {
  FloatPair product = unnormalised_product(a, b);
  FloatPair sum = two_sum(product.high, c.high);
  PRECISE float lows = product.low + c.low;
  PRECISE float low = sum.low + lows;
  return fast_two_sum(sum.high, low);
}

// 1 / x. Vulkan promises 2.5 units in the last place of a division: a step of Newton's first makes it one.
FUNCTION FloatPair inverse_pair(FloatPair x) {
  float rough = 1.0f / x.high;
  FloatPair of_rough = two_product(x.high, rough);
  PRECISE float rough_misses = 1.0f - of_rough.high;
  PRECISE float rough_off = rough_misses - of_rough.low;
  PRECISE float correction = rough * rough_off;
  PRECISE float near = rough + correction;
  FloatPair of_near = two_product(x.high, near);
  PRECISE float misses = 1.0f - of_near.high;
  PRECISE float misses_low = misses - of_near.low;
  PRECISE float of_low = x.low * near;
  PRECISE float off = misses_low - of_low;
  PRECISE float low = near * off;
  return fast_two_sum(near, low);
}

// 1 / sqrt(x): two steps of Newton's from what the device has, the second in pairs.
FUNCTION FloatPair inverse_root(FloatPair x) {
  float rough = inversesqrt(x.high);
  PRECISE float squared = rough * rough;
  PRECISE float product = x.high * squared;
  PRECISE float off = 1.0f - product;
  PRECISE float half_rough = 0.5f * rough;
  PRECISE float step = half_rough * off;
  PRECISE float near = rough + step;
  FloatPair missing = subtract(pair(1.0f, 0.0f), times(x, two_product(near, near)));
  PRECISE float half_near = 0.5f * near;
  PRECISE float low = half_near * missing.high;
  return fast_two_sum(near, low);
}

// log2(x) of a normal x: 2 / ln 2 times the series of the inverse hyperbolic tangent. Off by 1e-9.
FUNCTION FloatPair log2_of(float x) {
  int exponent = int(floatBitsToUint(x) >> 23) - 127;
  float m = uintBitsToFloat((floatBitsToUint(x) & 0x007fffffu) | 0x3f800000u);
  if (m > 1.41421356f) {
    m = 0.5f * m;
    exponent = exponent + 1;
  }
  FloatPair above = two_sum(m, -1.0f);
  FloatPair t = times(above, inverse_pair(two_sum(m, 1.0f)));
  PRECISE float s = t.high * t.high;
  PRECISE float s5 = s * 0.262308189f;
  PRECISE float p4 = s5 + 0.320598898f;
  PRECISE float s4 = s * p4;
  PRECISE float p3 = s4 + 0.412198583f;
  PRECISE float s3 = s * p3;
  PRECISE float p2 = s3 + 0.577078016f;
  PRECISE float s2 = s * p2;
  PRECISE float p1 = s2 + 0.961796694f;
  PRECISE float cube = t.high * s;
  PRECISE float rest = cube * p1;
  FloatPair line = times(t, pair(2.885390043f, 3.85192607e-08f));
  return add(pair(float(exponent), 0.0f), add(line, pair(rest, 0.0f)));
}

// 2^-s for s >= 0, a unit in the last place, by the series of the remainder of an integer.
FUNCTION float exp2_negative(float s) {
  const float whole = roundEven(s);
  if (!(whole <= 126.0f)) return 0.0f;
  PRECISE float x = whole - s;
  PRECISE float p6 = x * 1.540353039e-4f;
  PRECISE float p5 = p6 + 1.333355815e-3f;
  PRECISE float t5 = x * p5;
  PRECISE float p4 = t5 + 9.618129108e-3f;
  PRECISE float t4 = x * p4;
  PRECISE float p3 = t4 + 5.550410866e-2f;
  PRECISE float t3 = x * p3;
  PRECISE float p2 = t3 + 2.402265070e-1f;
  PRECISE float t2 = x * p2;
  PRECISE float p1 = t2 + 6.931471806e-1f;
  PRECISE float t1 = x * p1;
  PRECISE float p0 = t1 + 1.0f;
  return p0 * uintBitsToFloat((127u - uint(whole)) << 23);
}
