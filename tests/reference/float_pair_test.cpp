// SPDX-License-Identifier: Apache-2.0

// Pairs of floats against long double.
#include <algorithm>
#include <cmath>
#include <limits>

#include <doctest/doctest.h>

#include <swiftgs/frame/float_pair.hpp>

#include "reference/hostile_pairs.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// 64 bits: a product of two pairs rounds by 2^-16 of what pairs may be off.
using Wide = long double;
static_assert(std::numeric_limits<Wide>::digits >= 64);

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();
const Wide u = std::ldexp(Wide(1), -24);

Wide wide(FloatPair x) { return Wide(x.high) + Wide(x.low); }

/// Whether high is the sum rounded to float, or no number.
bool is_normalised(FloatPair x) { return !(std::isfinite(x.high) && x.high + x.low != x.high); }

/// The most that results were off, in the units of their bounds.
struct Worst {
  Wide of_bound = 0;
  bool normalised = true;

  void add(FloatPair found, Wide exact, Wide bound) {
    of_bound = std::max(of_bound, std::abs(wide(found) - exact) / bound);
    normalised = normalised && is_normalised(found);
  }
  /// `least`: a looser bound would hide a worse algorithm.
  void check(double least) const {
    CHECK(double(of_bound) <= 1);
    CHECK(double(of_bound) >= least);
    CHECK(normalised);
  }
};

constexpr int trials = 300'000;

}  // namespace

TEST_CASE("float pair: sums and products of two floats are exact") {
  Hostile hostile(1);
  bool sums = true, fast_sums = true, products = true;
  for (int i = 0; i < trials; ++i) {
    // Exponents so near to each other that long double holds the sum.
    const float a = hostile.number(-60, 60), b = std::ldexp(hostile.number(-38, 38), std::ilogb(a));
    const FloatPair sum = two_sum(a, b), product = two_product(a, b);
    sums = sums && wide(sum) == Wide(a) + Wide(b) && is_normalised(sum);
    const bool first = std::abs(a) >= std::abs(b);
    const FloatPair fast = fast_two_sum(first ? a : b, first ? b : a);
    fast_sums = fast_sums && fast.high == sum.high && fast.low == sum.low;
    if (std::abs(Wide(a) * Wide(b)) >= 0x1p-102L && std::abs(Wide(a) * Wide(b)) < 0x1p127L)
      products = products && wide(product) == Wide(a) * Wide(b);
  }
  CHECK(sums);
  CHECK(fast_sums);
  CHECK(products);
}

TEST_CASE("float pair: a double loses no more than half of a square") {
  Hostile hostile(2);
  Worst worst;
  for (int i = 0; i < trials; ++i) {
    const double x = double(hostile.pair(-90, 120)) * (1 + 0x1p-48 * hostile.below(32));
    worst.add(FloatPair::from(x), Wide(x), u * u / 2 * std::abs(Wide(x)));
  }
  worst.check(0.5);
  CHECK(double(FloatPair::from(1.0 / 3)) == doctest::Approx(1.0 / 3).epsilon(1e-14));
  CHECK(float(FloatPair::from(1.0 / 3)) == 1.0f / 3);
}

TEST_CASE("float pair: differences keep their bound where digits cancel") {
  Hostile hostile(3);
  Worst worst;
  for (int i = 0; i < trials; ++i) {
    const FloatPair b = hostile.pair(-60, 60);
    const float near = std::ldexp(hostile.number(-3, 3), std::ilogb(b.high));
    const float a = i % 2 ? near : b.high + 0x1p-22f * float(hostile.below(3)) * near;
    const Wide exact = Wide(a) - wide(b);
    if (exact != 0) worst.add(a - b, exact, 2 * u * u * std::abs(exact));
  }
  worst.check(0.4);
}

TEST_CASE("float pair: products and multiply_add keep their bounds") {
  Hostile hostile(4);
  Worst product, sum;
  for (int i = 0; i < trials; ++i) {
    const FloatPair a = hostile.pair(-30, 40), b = hostile.pair(-30, 40);
    const Wide exact = wide(a) * wide(b);
    product.add(a * b, exact, 6 * u * u * std::abs(exact));
    FloatPair c = hostile.pair(-60, 80);
    if (i % 2) {  // cancels most of the product
      c = FloatPair::from(-double(exact));
      if (i % 4 == 1) c = fast_two_sum(c.high, c.low * float(hostile.below(3)));
    }
    // And what was left out in u^3.
    const Wide bound = u * u * (13 * std::abs(exact) + 3 * std::abs(wide(c))) * (1 + 4 * u);
    sum.add(multiply_add(a, b, c), exact + wide(c), bound);
  }
  product.check(0.6);
  sum.check(0.3);
}

TEST_CASE("float pair: inverses keep their bound") {
  Hostile hostile(5);
  Worst worst, beyond;
  for (int i = 0; i < trials; ++i) {
    const FloatPair x = hostile.pair(-126, 101), large = hostile.pair(102, 126);
    worst.add(inverse(x), 1 / wide(x), 8 * u * u / std::abs(wide(x)) * (1 + 8 * u));
    beyond.add(inverse(large), 1 / wide(large), 8 * u * u / std::abs(wide(large)) + 0x1p-149L);
  }
  worst.check(0.5);
  beyond.check(0.4);
}

TEST_CASE("float pair: products below the range are off by less than the least float") {
  Hostile hostile(6);
  Worst worst;
  for (int i = 0; i < trials; ++i) {
    const FloatPair a = hostile.pair(-100, -40), b = hostile.pair(-49, -20);
    const FloatPair c = i % 3 == 0 ? FloatPair{0, 0} : hostile.pair(-120, -90);
    const Wide exact = wide(a) * wide(b);
    const Wide bound = u * u * (13 * std::abs(exact) + 3 * std::abs(wide(c))) + 0x1p-148L;
    worst.add(a * b, exact, bound);
    worst.add(multiply_add(a, b, c), exact + wide(c), bound);
  }
  worst.check(0.5);
}

TEST_CASE("float pair: what leaves the range of float is not finite") {
  Hostile hostile(7);
  bool found = true;
  for (int i = 0; i < trials; ++i) {
    const FloatPair large = hostile.pair(70, 126), other = hostile.pair(58, 126),
                    any = hostile.pair(-100, 126);
    found = found && !std::isfinite((large * other).high) &&
            !std::isfinite(multiply_add(large, other, any).high) &&
            !std::isfinite(multiply_add(any, FloatPair{1, 0}, large * other).high);
  }
  CHECK(found);
  for (const FloatPair bad : {FloatPair::from(1e39), FloatPair::from(-1e300), FloatPair{infinity, 0},
                              FloatPair{not_a_number, 0}, FloatPair::from(double(not_a_number))}) {
    const FloatPair one{1, 0}, zero{0, 0};
    for (const FloatPair made :
         {bad * one, one * bad, multiply_add(bad, one, one), multiply_add(one, bad, one),
          multiply_add(one, one, bad), multiply_add(zero, zero, bad), 1.0f - bad})
      CHECK(!std::isfinite(made.high));
    CHECK(std::isnan(inverse(bad).high));
  }
  CHECK(!std::isfinite((infinity - FloatPair{1, 0}).high));
  CHECK(!std::isfinite((not_a_number - FloatPair{1, 0}).high));
  for (const float none : {0.0f, -0.0f, 0x1p-149f, 0x1p-129f}) CHECK(std::isnan(inverse({none, 0}).high));
}

TEST_CASE("float pair: zeros and subnormal numbers are exact") {
  CHECK((FloatPair{0, 0} * FloatPair{2, 0}).high == 0);
  CHECK((1.0f - FloatPair{1, 0}).high == 0);
  const FloatPair least{0x1p-149f, 0};
  CHECK((least * FloatPair{3, 0}).high == 3 * 0x1p-149f);
  CHECK(multiply_add(least, FloatPair{2, 0}, least).high == 3 * 0x1p-149f);
  CHECK((0x1p-148f - least).high == 0x1p-149f);
}
