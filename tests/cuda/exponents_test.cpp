// SPDX-License-Identifier: Apache-2.0

// The exponents of kernels, on the host.
#include "exponents.hpp"

#include <algorithm>
#include <cmath>

#include <doctest/doctest.h>

#include <swiftgs/lens/view.hpp>

#include "blending.hpp"
#include "cuda/exact_square.hpp"
#include "other_exponents.hpp"
#include "policies/random_splats.hpp"

using namespace swiftgs;
using namespace swiftgs::kernels;
using namespace swiftgs::test;

namespace {

const BlendRules rules = blend_rules(Conventions::gsplat());

/// Largest of what is divided by its bound; infinite where one is not a number.
struct Worst {
  double ratio = 0;
  void add(double error, double bound) {
    const double r = std::abs(error) / bound;
    ratio = r >= 0 ? std::max(ratio, r) : INFINITY;
  }
};

/// log2 of alpha_max, the unit of alphas that representations find.
const double log2_unit = std::log2(double(rules.alpha_max));

/// Whether `alpha` is what `rules` make of 2^exponent, which may be off by `error`.
bool alpha_allowed(float alpha, double exponent, double error) {
  const double slack = error + 4 * epsilon, minimum = double(rules.alpha_min),
               maximum = double(rules.alpha_max);
  const double low = std::exp2(exponent - slack), high = std::exp2(exponent + slack);
  if (alpha == 0) return low < minimum;
  return high >= minimum && double(alpha) >= std::min(low, maximum) &&
         double(alpha) <= std::min(high, maximum);
}

/// Calls f(shape, first centre of a warp block) for splats of all kinds and warp blocks that they may touch.
template <class F>
void for_each_splat_and_part(const F& f) {
  Random random(7);
  for (int i = 0; i < 4000; ++i) {
    const bool usual = i % 2;
    const SplatShape shape = usual ? usual_splat(random, 64, 64) : random_splat(random, 64, 64);
    const auto begin = [&] { return float(part * int(random.in(0, 8))) + 0.5f; };
    const float x = begin();
    f(shape, vec2(x, begin()), usual);
  }
}

/// Compares the exponents and the alphas of a representation with double at all pixels of warp blocks.
/// `error_of` bounds it.
template <class Exponent, class ErrorOf>
void check_exponent(const ErrorOf& error_of) {
  Worst worst, worst_usual;
  int kept = 0, wrong_alphas = 0, unlike = 0;
  for_each_splat_and_part([&](const SplatShape& shape, vec2 first, bool usual) {
    float4 terms;
    typename Exponent::Rest rest;
    Exponent::prepare(shape, shape.from_mean(first), relative_log2_opacity(shape, rules), terms, rest);
    for (int lane = 0; lane < 32; ++lane) {
      const int x = lane % (part / 2), y = lane / (part / 2);
      float exponents[pixels_of_lane];
      Exponent::evaluate(terms, rest, float(x), float(y), exponents);
      for (unsigned p = 0; p < pixels_of_lane; ++p) {
        const float one = Exponent::evaluate_one(terms, rest, float(x), float(y), float(p * columns_between));
        unlike += !(one == exponents[p]);
        const double at_x = double(first.x) + x + p * columns_between, at_y = double(first.y) + y;
        const ExactSquare exact(shape, at_x, at_y);
        const double exponent = std::log2(double(shape.opacity)) - exact.s, error = error_of(exact, shape);
        const double off = double(exponents[p]) + log2_unit - exponent;
        worst.add(off, error);
        if (usual && exact.s <= double(shape.cutoff)) worst_usual.add(off, 1e-4), ++kept;
        const auto is_wrong = [&](float relative) {
          return !alpha_allowed(relative * rules.alpha_max, exponent, error);
        };
        wrong_alphas += is_wrong(relative_alpha<false>(exponents[p], rules));
        wrong_alphas += is_wrong(relative_alpha<true>(exponents[p], rules));
      }
    }
  });
  CHECK(worst.ratio <= 1);
  CHECK(kept > 10'000);
  CHECK(worst_usual.ratio <= 1);
  CHECK(wrong_alphas == 0);
  CHECK(unlike == 0);
}

}  // namespace

TEST_CASE("cuda arithmetic: the Cholesky representation's exponents are those of double") {
  check_exponent<CholeskyExponent>([](const ExactSquare& exact, const SplatShape&) { return exact.error; });
}

TEST_CASE("cuda arithmetic: the split representation's exponents are those of double") {
  check_exponent<SplitExponent>(
      [](const ExactSquare& exact, const SplatShape& shape) { return exact.split_error(shape); });
}

TEST_CASE("cuda arithmetic: the split representation takes s that rounding makes negative for 0") {
  // At its mean a splat has the largest exponent there is. A negative c stands for what rounding does.
  SplatShape shape = make_splat(3.5, 2.5, 2, 1, 0.4, 0.8);
  float4 terms;
  SplitExponent::Rest rest;
  float exponents[pixels_of_lane];
  SplitExponent::prepare(shape, shape.from_mean(vec2(0.5f)), relative_log2_opacity(shape, rules), terms,
                         rest);
  SplitExponent::evaluate(terms, rest, 3, 2, exponents);
  CHECK(exponents[0] == doctest::Approx(rest.z).epsilon(1e-6));
  terms.z = -10;
  SplitExponent::evaluate(terms, rest, 3, 2, exponents);
  CHECK(exponents[0] == rest.z);
  CHECK(exponents[1] == rest.z);

  // Nothing is shown of a splat whose squares no float holds.
  shape.l0 = 1e25f;
  SplitExponent::prepare(shape, shape.from_mean(vec2(0.5f)), relative_log2_opacity(shape, rules), terms,
                         rest);
  SplitExponent::evaluate(terms, rest, 3, 2, exponents);
  CHECK(exponents[0] == -INFINITY);
}

TEST_CASE("cuda arithmetic: alphas of the factor as it is stored are those of double") {
  int kept = 0, wrong = 0;
  for_each_splat_and_part([&](const SplatShape& shape, vec2 first, bool) {
    const float4 factor = FactorExponent::prepare(shape);
    for (int pixel = 0; pixel < part * part; ++pixel) {
      const float x = first.x + float(pixel % part), y = first.y + float(pixel / part);
      const float alpha = FactorExponent::alpha(factor, shape.right_of_mean(x), shape.below_mean(y), rules);
      const ExactSquare exact(shape, double(x), double(y));
      kept += alpha > 0;
      wrong += !alpha_allowed(alpha, std::log2(double(shape.opacity)) - exact.s, exact.error);
    }
  });
  CHECK(kept > 10'000);
  CHECK(wrong == 0);
}

TEST_CASE("cuda arithmetic: the factor representation refuses no opacity and terms that are not numbers") {
  const float4 factor = FactorExponent::prepare(make_splat(4, 4, 3, 3, 0, 0.9));
  REQUIRE(FactorExponent::alpha(factor, 1, 0, rules) > 0.5f);
  float4 broken = factor;
  broken.w = 0;
  CHECK(FactorExponent::alpha(broken, 1, 0, rules) == 0);
  broken = factor, broken.x = NAN;
  CHECK(FactorExponent::alpha(broken, 1, 0, rules) == 0);
}
