// SPDX-License-Identifier: Apache-2.0

// The sRGB curve, and what a pixel's colours become by it.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include <doctest/doctest.h>

#include <swiftgs/frame/half.hpp>
#include <swiftgs/frame/srgb.hpp>
#include <swiftgs/raster/store.hpp>

namespace swiftgs::test::srgb_test {

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

double encoded(double x) {
  return x <= double(0.0031308f) ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
}
double decoded(double x) { return x <= double(0.04045f) ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4); }

/// Largest error of f over floats from `from` to `to`, in units in the last place.
template <class F, class Exact>
double largest_error(const F& f, const Exact& exact, float from, float to) {
  double worst = 0;
  for (auto bits = std::bit_cast<std::uint32_t>(from); bits <= std::bit_cast<std::uint32_t>(to);
       bits += 101) {
    const float x = std::bit_cast<float>(bits);
    const double expected = exact(double(x));
    if (!(expected < 3e38)) break;
    worst = std::max(worst, std::abs(double(f(x)) - expected) / std::ldexp(1.0, std::ilogb(expected) - 23));
    if (f(-x) != -f(x)) return infinity;
  }
  return worst;
}

}  // namespace

TEST_CASE("srgb: values are within seven units in the last place of the exact curve") {
  for (const auto& [from, to] : {std::pair{1e-30f, 0.003f}, {0.003f, 1.0f}, {1.0f, 3e38f}}) {
    CAPTURE(from);
    CHECK(largest_error(to_srgb, encoded, from, to) <= 7);
    CHECK(largest_error(from_srgb, decoded, from, to) <= 7);
  }
  CHECK(to_srgb(0) == 0);
  CHECK(from_srgb(0) == 0);
  CHECK(to_srgb(1) == doctest::Approx(1).epsilon(2e-7));
  CHECK(from_srgb(1) == doctest::Approx(1).epsilon(2e-7));
}

TEST_CASE("srgb: what is no number or infinite stays so") {
  for (const auto curve : {to_srgb, from_srgb}) {
    CHECK(std::isnan(curve(not_a_number)));
    CHECK(curve(infinity) == infinity);
    CHECK(curve(-infinity) == -infinity);
    CHECK(std::signbit(curve(-0.0f)));
    CHECK(curve(1e-42f) >= 0);
  }
}

TEST_CASE("srgb: 8 bits and halves come back from linear light and from encoded values") {
  for (int k = 0; k <= 255; ++k) {
    CHECK(to_unorm8(to_srgb(from_srgb(float(k) / 255))) == k);
    CHECK(to_unorm8(from_srgb(to_srgb(float(k) / 255))) == k);
  }
  int changed = 0;
  for (std::uint32_t bits = 0; bits < 0x7c00; ++bits) {
    const float value = to_float(Half{std::uint16_t(bits)});
    changed += to_half(to_srgb(from_srgb(value))).bits != bits;
    changed += to_half(from_srgb(to_srgb(value))).bits != bits;
  }
  CHECK(changed == 0);
}

TEST_CASE("srgb: straight colours are converted and hostile pixels touch nothing else") {
  float pixel[4];
  FrameView frame{
      .width = 1, .height = 1, .colour = {pixel, sizeof pixel}, .format = PixelFormat::rgba_float};
  frame.conversion = Conversion::linear_to_srgb;
  const auto stored = [&](vec3 colour, float transmittance, vec3 background = vec3(0)) {
    store_pixel(frame, 0, 0, {colour, transmittance}, background);
    return vec4(pixel[0], pixel[1], pixel[2], pixel[3]);
  };
  const vec4 half = stored({0.1f, 0.25f, 3}, 0.5f);
  CHECK(half.r == doctest::Approx(0.5 * encoded(0.2)).epsilon(1e-6));
  CHECK(half.g == doctest::Approx(0.5 * encoded(0.5)).epsilon(1e-6));
  CHECK(half.b == doctest::Approx(0.5 * encoded(6)).epsilon(1e-6));
  CHECK(half.a == 0.5f);
  CHECK(stored({0, 0, 0}, 1) == vec4(0));
  CHECK(stored({1e-9f, 0, 0}, 1) == vec4(0));  // alpha rounds to 0
  CHECK(stored({0.1f, 0, 0}, 0.5f, {0.2f, 0, -0.2f}) ==
        vec4(to_srgb(0.1f + 0.5f * 0.2f), 0, to_srgb(-0.1f), 0.5f));  // a whole picture
  const vec4 hostile = stored({not_a_number, infinity, 0.5f}, 0);
  CHECK(std::isnan(hostile.r));
  CHECK(hostile.g == infinity);
  CHECK(hostile.b == to_srgb(0.5f));
  CHECK(hostile.a == 1);

  frame.over = true;
  const auto laid_on = [&](vec4 below, vec3 colour, float transmittance) {
    for (int c = 0; c < 4; ++c) pixel[c] = below[c];
    return stored(colour, transmittance);
  };
  // An encoded image below is decoded, blended and encoded again.
  CHECK(laid_on({float(encoded(0.3)), 0, 0, 1}, {0.2f, 0, 0}, 0.5f).r ==
        doctest::Approx(encoded(0.2 + 0.5 * 0.3)).epsilon(1e-6));
  CHECK(laid_on({0.25f * float(encoded(0.3)), 0, 0, 0.25f}, {0, 0, 0}, 1).r ==
        doctest::Approx(0.25 * encoded(0.3)).epsilon(1e-6));
  CHECK(laid_on({0.4f, 0.4f, 0.4f, 0}, {0.2f, 0, 0}, 0.5f) == vec4(0.5f * to_srgb(0.4f), 0, 0, 0.5f));
  for (const float alpha : {-1.0f, not_a_number, 0.0f}) {
    const vec4 odd = laid_on({1, -1, not_a_number, alpha}, {0.2f, 0.3f, 0.4f}, 0);
    CHECK((std::isnan(alpha) || odd == vec4(to_srgb(0.2f), to_srgb(0.3f), to_srgb(0.4f), 1)));
  }
}

}  // namespace swiftgs::test::srgb_test
