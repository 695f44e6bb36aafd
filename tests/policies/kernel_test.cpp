// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include <doctest/doctest.h>

#include "policies/rasterizers.hpp"

namespace swiftgs::test::kernel_test {

namespace {

/// s of a pixel in double, from the splat's own numbers.
double exponent(const SplatShape& s, double x, double y) {
  const double dx = x - s.exact_mean().x, dy = y - s.exact_mean().y;
  const double u = double(s.l0) * dx + double(s.l1) * dy, v = double(s.l2) * dy;
  return u * u + v * v;
}

/// Largest term of a dx^2 + c dy^2 + b dx dy: what the split representations round, and what their errors
/// scale with.
double largest_term(const SplatShape& s, double x, double y) {
  const double dx = x - s.exact_mean().x, dy = y - s.exact_mean().y;
  const double l0 = s.l0, l1 = s.l1, l2 = s.l2;
  return std::max({l0 * l0 * dx * dx, (l1 * l1 + l2 * l2) * dy * dy, std::abs(2 * l0 * l1 * dx * dy)});
}

std::vector<SplatShape> splats_near_the_tile() {
  Random random(3);
  std::vector<SplatShape> shapes;
  for (int i = 0; i < 2000; ++i) {
    const double across = random.scale(0.5478, 60), along = across * random.scale(1, 20);
    shapes.push_back(make_splat(72 + random.in(-1, 1) * (8 + along), 40 + random.in(-1, 1) * (8 + along),
                                along, across, random.in(0, 3.14159), random.scale(1.0 / 250, 1)));
  }
  return shapes;
}

/// Error of s where it is the sum of two squares: u = p + q is a difference of terms that may each be far
/// larger; their roundings count, but only once and before squaring.
double factor_error(const SplatShape& s, double x, double y) {
  const double dx = x - s.exact_mean().x, dy = y - s.exact_mean().y;
  const double terms = std::abs(double(s.l0) * dx) + std::abs(double(s.l1) * dy);
  const double u = std::abs(double(s.l0) * dx + double(s.l1) * dy), error = 3 * 0x1p-24 * terms;
  return 2 * u * error + error * error + 6 * 0x1p-24 * (exponent(s, x, y) + double(s.cutoff)) + 1e-6;
}

/// The bound that `FloatSplit` states, beside the error of the terms that it begins with.
double float_split_error(const SplatShape& s, double x, double y) {
  const double dx = x - s.exact_mean().x, dy = y - s.exact_mean().y;
  const double wide =
      std::abs(double(s.l0) * dx + double(s.l1) * dy) + 16 * (double(s.l0) + std::abs(double(s.l1)));
  const double high = double(s.l2) * (std::abs(dy) + 16);
  return factor_error(s, x, y) + std::ldexp(wide * wide + high * high, -18);
}

/// Compares every pixel of a tile with double; `bound(shape, x, y)` is the error allowed in s.
/// `skipped_up_to`: where rounding may make s negative, within so many bounds, the pixel may skip the splat.
template <class Raster, class Bound>
void check_alphas(const Bound& bound, double skipped_up_to = 0) {
  CAPTURE(Raster::name);
  const BlendRules rules = blend_rules(Conventions::gsplat());
  double worst = 0;         // error of a kept alpha over its bound
  int wrongly_decided = 0;  // pixels kept or skipped although s is clear of the threshold by the bound
  std::size_t kept = 0;
  for (const SplatShape& shape : splats_near_the_tile()) {
    typename Raster::Kernel kernel(shape, vec2(64.5f, 32.5f), rules);
    for (int row = 0; row < raster_block_side; ++row) {
      kernel.start_row(32.5f + float(row));
      for (int column = 0; column < raster_block_side; ++column) {
        const double x = 64.5 + column, y = 32.5 + row;
        const double s = exponent(shape, x, y), allowed = bound(shape, x, y);
        const float alpha = kernel.alpha(column);
        if (s < double(shape.cutoff) - allowed && s >= skipped_up_to * allowed) wrongly_decided += alpha == 0;
        if (s > double(shape.cutoff) + allowed) wrongly_decided += alpha != 0;
        if (alpha == 0) continue;
        ++kept;
        const double exact = std::min(0.99, double(shape.opacity) * std::exp2(-s));
        // d alpha / d s is -ln 2 alpha; e^x - 1 bounds it over the whole allowed range.
        const double tolerance = exact * std::expm1(0.7 * allowed) + 3e-7;
        worst = std::max(worst, std::abs(double(alpha) - exact) / tolerance);
      }
    }
  }
  CHECK(worst <= 1);
  CHECK(wrongly_decided == 0);
  CHECK(kept > 50'000);
}

}  // namespace

TEST_CASE("kernel: means are rounded down, keep what that cuts off, and are subtracted without loss") {
  Random random(31);
  for (int i = 0; i < 20'000; ++i) {
    const double x = random.in(-1, 1) * random.scale(1e-3, 65'535), y = random.in(0, 65'536);
    SplatShape of_double, of_pair;
    of_double.set_mean(x, y), of_pair.set_mean(FloatPair::from(x), FloatPair::from(y));
    REQUIRE(of_pair.mean == of_double.mean);
    for (const SplatShape& shape : {of_double, of_pair}) {
      const Vector2<double> kept = shape.exact_mean();
      REQUIRE(double(shape.mean.x) <= x);
      REQUIRE(double(shape.mean.y) <= y);
      // Within half a unit, and a whole one where the remainder is nearly the next float.
      REQUIRE(std::abs(kept.x - x) <= 0x1p-24);
      REQUIRE(std::abs(kept.y - y) <= 0x1p-24);
      const float at = std::floor(float(x)) + 0.5f;
      REQUIRE(std::abs(double(shape.right_of_mean(at)) - (double(at) - kept.x)) <= 0x1p-24);
    }
  }
}

TEST_CASE("kernel: alpha is that of double within what each representation rounds") {
  check_alphas<PerPixel>(factor_error);
  check_alphas<AxisShared<FloatCholesky>>(factor_error);
  check_alphas<AxisSharedThreshold<FloatCholesky>>(factor_error);
  check_alphas<AxisShared<FloatSplit>>(float_split_error);
  check_alphas<AxisSharedThreshold<FloatSplit>>(float_split_error);
  // Two of the three terms carry one rounding of 2^-11, the mixed term two; subnormal terms 2^-25 each.
  const auto half_split_error = [](const SplatShape& s, double x, double y) {
    return 4.1 * 0x1p-11 * largest_term(s, x, y) + 2e-5;
  };
  check_alphas<AxisShared<HalfSplit>>(half_split_error, 1);
  check_alphas<AxisSharedThreshold<HalfSplit>>(half_split_error, 1);
}

TEST_CASE("kernel: alpha is cut at its maximum and no lower") {
  for_each_raster([]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    const BlendRules rules = blend_rules(Conventions::gsplat());
    const SplatShape opaque = make_splat(8.5, 8.5, 4, 4, 0, 1), clear = make_splat(8.5, 8.5, 4, 4, 0, 0.98);
    typename Raster::Kernel solid(opaque, vec2(0.5f, 0.5f), rules), below(clear, vec2(0.5f, 0.5f), rules);
    solid.start_row(8.5f), below.start_row(8.5f);
    CHECK(solid.alpha(8) == 0.99f);
    CHECK(below.alpha(8) == doctest::Approx(0.98).epsilon(1e-6));
  });
}

TEST_CASE("kernel: a half-split term that overflows keeps no pixel and is never an alpha") {
  const BlendRules rules = blend_rules(Conventions::gsplat());
  // 1,500 pixels from the mean of a needle of one pixel: a dx^2 is 1.6 million, and infinite minus infinite
  // comes up along its diagonal.
  const SplatShape needle = make_splat(-1500, -1500, 2000, 0.6, 0.785398, 1);
  AxisSharedThreshold<HalfSplit>::Kernel threshold(needle, vec2(0.5f, 0.5f), rules);
  AxisShared<HalfSplit>::Kernel plain(needle, vec2(0.5f, 0.5f), rules);
  for (int row = 0; row < raster_block_side; ++row) {
    threshold.start_row(0.5f + float(row)), plain.start_row(0.5f + float(row));
    for (int column = 0; column < raster_block_side; ++column) {
      CHECK(threshold.alpha(column) == 0);
      CHECK(plain.alpha(column) == 0);
    }
  }
}

}  // namespace swiftgs::test::kernel_test
