// SPDX-License-Identifier: Apache-2.0

// Arithmetic in pairs of floats as swiftgs/frame/float_pair.hpp has it: high + low, where high is the sum rounded to
// float. Products are split into halves unless FUSES, because `fma` of Vulkan may round twice. Each operation has a name
// of its own, `precise`, so that no compiler fuses or reorders. tests/vulkan compiles this file as C++.

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

// Loose pairs are not rounded to float at `high`: |low| is up to some u |high|, with u = 2^-24. Sums and products take
// them; `tight` rounds.
FUNCTION FloatPair tight(FloatPair a) { return fast_two_sum(a.high, a.low); }

// Off by 3 u^2 (|a| + |b|).
FUNCTION FloatPair loose_sum(FloatPair a, FloatPair b) {
  FloatPair sum = two_sum(a.high, b.high);
  PRECISE float lows = a.low + b.low;
  PRECISE float low = sum.low + lows;
  return pair(sum.high, low);
}
FUNCTION FloatPair add(FloatPair a, FloatPair b) { return tight(loose_sum(a, b)); }
FUNCTION FloatPair subtract(FloatPair a, FloatPair b) { return add(a, negative(b)); }

// a - b, off by 2 u^2 |a - b|.
FUNCTION FloatPair float_minus(float a, FloatPair b) {
  FloatPair sum = two_sum(a, -b.high);
  PRECISE float low = sum.low - b.low;
  return fast_two_sum(sum.high, low);
}

// Off by 7 u^2 |a b|. Low parts do not ask for an `fma` that rounds once.
FUNCTION FloatPair loose_product(FloatPair a, FloatPair b) {
  FloatPair product = two_product(a.high, b.high);
  PRECISE float with_low = fma(a.high, b.low, product.low);
  PRECISE float low = fma(a.low, b.high, with_low);
  return pair(product.high, low);
}
FUNCTION FloatPair times(FloatPair a, FloatPair b) { return tight(loose_product(a, b)); }

// a b + c.
FUNCTION FloatPair multiply_add(FloatPair a, FloatPair b, FloatPair c) { return tight(loose_sum(loose_product(a, b), c)); }

// a - b c, where that is small beside a: exact but for one rounding.
FUNCTION float rest_of(float a, float b, float c) {
  if (FUSES) {
    PRECISE float fused = fma(-b, c, a);
    return fused;
  }
  FloatPair product = split_product(b, c);
  PRECISE float rest = a - product.high;
  PRECISE float whole = rest - product.low;
  return whole;
}

// 1 / x, off by 32 u^2 / |x|: a step of Newton's from a division, of which Vulkan promises 2.5 units in the last place.
FUNCTION FloatPair inverse_pair(FloatPair x) {
  float near = 1.0f / x.high;
  PRECISE float off = fma(-x.low, near, rest_of(1.0f, x.high, near));
  PRECISE float low = near * off;
  return fast_two_sum(near, low);
}

// 1 / sqrt(x): two steps of Newton's from what the device has, which is off by two units; the second is in pairs.
FUNCTION FloatPair inverse_root(FloatPair x) {
  float rough = inversesqrt(x.high);
  PRECISE float product = x.high * rough;
  PRECISE float rough_off = fma(-product, rough, 1.0f);
  PRECISE float half_rough = 0.5f * rough;
  PRECISE float near = fma(half_rough, rough_off, rough);
  FloatPair squared = two_product(near, near);
  PRECISE float by_low = x.low * squared.high;
  PRECISE float of_lows = fma(x.high, squared.low, by_low);
  PRECISE float off = rest_of(1.0f, x.high, squared.high) - of_lows;
  PRECISE float half_near = 0.5f * near;
  PRECISE float low = half_near * off;
  return fast_two_sum(near, low);
}

// sqrt(x), 0 where x is not above it.
FUNCTION float root(float x) {
  if (!(x > 0.0f)) return 0.0f;
  float inverse = inversesqrt(x);
  PRECISE float near = x * inverse;
  PRECISE float half_inverse = 0.5f * inverse;
  PRECISE float step = half_inverse * rest_of(x, near, near);
  PRECISE float exact = near + step;
  return exact;
}

// log2(x) of a normal x: 2 / ln 2 times the series of the inverse hyperbolic tangent. Off by 1e-9.
FUNCTION FloatPair log2_of(float x) {
  int exponent = int(floatBitsToUint(x) >> 23) - 127;
  float m = uintBitsToFloat((floatBitsToUint(x) & 0x007fffffu) | 0x3f800000u);
  if (m > 1.41421356f) {
    m = 0.5f * m;
    exponent = exponent + 1;
  }
  FloatPair t = times(pair(m - 1.0f, 0.0f), inverse_pair(two_sum(m, 1.0f)));
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

// 2^-s for s > -127, off by three units in the last place at most, by the series of the remainder of an integer.
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
  return p0 * uintBitsToFloat(uint(127 - int(whole)) << 23);
}
