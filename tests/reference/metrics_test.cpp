// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/frame/span.hpp>
#include <swiftgs/metrics.hpp>

namespace swiftgs::test {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr float nan = std::numeric_limits<float>::quiet_NaN();

TEST_CASE(
    "metrics: psnr is 10 log10 of one over the mean squared difference so half an 8-bit step is 54 dB") {
  const std::vector<float> a{0, 0.5f, 1, 0.25f};
  const std::vector<double> b{0, 0.5, 0.8, 0.25};
  CHECK(psnr(a, b) == doctest::Approx(10 * std::log10(4 / 0.04)).epsilon(1e-14));
  CHECK(psnr(b, a) == psnr(a, b));
  CHECK(psnr(std::vector<double>(7, 0.0), std::vector<double>(7, 0.1)) == doctest::Approx(20).epsilon(1e-14));
  // Half an 8-bit step in every value.
  const std::vector<double> zero(7, 0.0), half_step(7, 0.5 / 255);
  CHECK(std::round(psnr(zero, half_step)) == 54);
  CHECK(psnr(std::vector<float>{0.5f, 2}, std::vector<double>{0.5, 2}) == infinity);
}

TEST_CASE("metrics: max_abs_difference finds the largest whichever its sign") {
  const std::vector<double> a{1, 2, 3};
  CHECK(max_abs_difference(a, std::vector<double>{1.25, 2, 2.5}) == 0.5);
  CHECK(max_abs_difference(a, std::vector<double>{1.25, 2, 3.75}) == 0.75);
  CHECK(max_abs_difference(a, a) == 0);
}

TEST_CASE("metrics: a NaN in an image is never mistaken for agreement") {
  const std::vector<float> a{1, nan, 3}, b{1, 2, 4}, c{1, nan, 3};
  CHECK(std::isnan(max_abs_difference(a, b)));
  CHECK(std::isnan(max_abs_difference(b, a)));
  CHECK(std::isnan(max_abs_difference(a, c)));
  CHECK(std::isnan(psnr(a, b)));
  CHECK(std::isnan(ssim(3, 1, 1, a, b)));
}

TEST_CASE("metrics: equal infinities agree and others are infinitely far") {
  const std::vector<double> a{infinity, 0}, b{-infinity, 0};
  CHECK(max_abs_difference(a, a) == 0);
  CHECK(psnr(a, a) == infinity);
  CHECK(max_abs_difference(a, b) == infinity);
  CHECK(psnr(a, b) == -infinity);
}

TEST_CASE("metrics: a span is an image too") {
  const std::vector<float> a{1, 2, 4};
  const Span<const float> view{a.data(), 3};
  CHECK(max_abs_difference(view, std::vector<double>{1, 2, 3}) == 1);
  CHECK(ssim(3, 1, 1, view, a) == doctest::Approx(1).epsilon(1e-15));
}

TEST_CASE("metrics: images of different sizes are refused") {
  const std::vector<float> a(12), b(11), none;
  CHECK_THROWS_WITH_AS(psnr(a, b),
                       "metrics: expected two images with the same number of values, got 12 and 11",
                       std::invalid_argument);
  CHECK_THROWS_AS(max_abs_difference(a, b), std::invalid_argument);
  CHECK_THROWS_AS(psnr(none, none), std::invalid_argument);
  CHECK_THROWS_AS(ssim(2, 2, 3, a, b), std::invalid_argument);
  CHECK_THROWS_WITH_AS(ssim(2, 3, 3, a, a), "ssim: expected 2 x 3 x 3 values, got 12", std::invalid_argument);
  CHECK_THROWS_AS(ssim(-2, -2, 3, a, a), std::invalid_argument);
}

TEST_CASE("metrics: ssim of an image with itself is 1 and of two even images its luminance term") {
  std::vector<double> image;
  for (int i = 0; i < 20 * 15 * 3; ++i) image.push_back(0.5 + 0.5 * std::sin(i * i));
  CHECK(ssim(20, 15, 3, image, image) == doctest::Approx(1).epsilon(1e-15));
  const std::vector<double> a(13 * 17, 0.25), b(13 * 17, 0.75);
  CHECK(ssim(13, 17, 1, a, b) ==
        doctest::Approx((2 * 0.25 * 0.75 + 1e-4) / (0.0625 + 0.5625 + 1e-4)).epsilon(1e-10));
}

TEST_CASE("metrics: ssim is the mean over windows that lie inside and over channels") {
  // One row of 13 pixels: three windows of 11 x 1. The reference value is summed window by window.
  std::vector<double> a, b;
  for (int x = 0; x < 13; ++x)
    for (int c = 0; c < 2; ++c) {
      a.push_back(0.5 + 0.4 * std::sin(3 * x + c));
      b.push_back(0.5 + 0.4 * std::cos(2 * x - c));
    }
  double expected = 0;
  for (int c = 0; c < 2; ++c)
    for (int first = 0; first < 3; ++first) {
      double total = 0, mean_a = 0, mean_b = 0, var_a = 0, var_b = 0, covariance = 0;
      const auto weight = [](int k) { return std::exp(-(k - 5) * (k - 5) / (2 * 1.5 * 1.5)); };
      const auto value = [&](const std::vector<double>& image, int k) {
        return image[std::size_t(2 * (first + k) + c)];
      };
      for (int k = 0; k < 11; ++k) total += weight(k);
      for (int k = 0; k < 11; ++k) {
        mean_a += weight(k) / total * value(a, k);
        mean_b += weight(k) / total * value(b, k);
      }
      for (int k = 0; k < 11; ++k) {
        const double da = value(a, k) - mean_a, db = value(b, k) - mean_b, w = weight(k) / total;
        var_a += w * da * da, var_b += w * db * db, covariance += w * da * db;
      }
      expected += (2 * mean_a * mean_b + 1e-4) * (2 * covariance + 9e-4) /
                  ((mean_a * mean_a + mean_b * mean_b + 1e-4) * (var_a + var_b + 9e-4)) / 6;
    }
  CHECK(ssim(13, 1, 2, a, b) == doctest::Approx(expected).epsilon(1e-12));
}

TEST_CASE("metrics: ssim treats rows and columns alike") {
  std::vector<double> a, b, a_turned(14 * 19), b_turned(14 * 19);
  for (std::size_t i = 0; i < 14 * 19; ++i) {
    const double v = double(i);
    a.push_back(0.5 + 0.5 * std::sin(v * v)), b.push_back(0.5 + 0.5 * std::sin(v * v + 0.3 * v));
    a_turned[i % 19 * 14 + i / 19] = a[i], b_turned[i % 19 * 14 + i / 19] = b[i];
  }
  CHECK(ssim(19, 14, 1, a, b) == doctest::Approx(ssim(14, 19, 1, a_turned, b_turned)).epsilon(1e-12));
  CHECK(ssim(19, 14, 1, a, b) < 0.9);
}

}  // namespace
}  // namespace swiftgs::test
