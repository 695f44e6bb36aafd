// SPDX-License-Identifier: Apache-2.0
#include <bit>
#include <cmath>
#include <cstdint>

#include <doctest/doctest.h>

#include <swiftgs/frame/half.hpp>

#include "policies/random_splats.hpp"

namespace swiftgs::test::half_test {

namespace {

/// The value of a half, from the definition of the format.
double value_of(std::uint16_t bits) {
  const int exponent = bits >> 10 & 31, fraction = bits & 1023;
  const double sign = bits >> 15 ? -1 : 1;
  if (exponent == 31) return fraction ? NAN : sign * INFINITY;
  if (exponent == 0) return sign * std::ldexp(fraction, -24);
  return sign * std::ldexp(1024 + fraction, exponent - 25);
}

/// The nearest half, ties to the even one: found by looking at all neighbours, not by bit tricks. Magnitudes
/// of 65,520 and more are infinite, which is where the half after the largest would begin.
std::uint16_t nearest_half(float value) {
  const std::uint16_t sign = std::signbit(value) ? 0x8000 : 0;
  if (std::isnan(value)) return std::uint16_t(sign | 0x7e00);
  const double magnitude = std::abs(double(value));
  if (magnitude >= 65520) return std::uint16_t(sign | 0x7c00);
  std::uint16_t low = 0, high = 0x7bff;  // bisect: halves ascend with their bits
  while (low < high) {
    const std::uint16_t middle = std::uint16_t((low + high + 1) / 2);
    value_of(middle) <= magnitude ? low = middle : high = std::uint16_t(middle - 1);
  }
  if (low == 0x7bff) return std::uint16_t(sign | low);
  const double below = magnitude - value_of(low), above = value_of(std::uint16_t(low + 1)) - magnitude;
  if (above < below || (above == below && low % 2 == 1)) ++low;
  return std::uint16_t(sign | low);
}

bool same_bits(float a, float b) {
  return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b);
}

}  // namespace

TEST_CASE("half: all 65536 become the float of their value and come back") {
  int wrong = 0;
  for (std::uint32_t bits = 0; bits < 65536; ++bits) {
    const float value = to_float(Half{std::uint16_t(bits)});
    const double expected = value_of(std::uint16_t(bits));
    if (std::isnan(expected)) {
      wrong += !std::isnan(value) || !std::isnan(to_float(to_half(value)));
    } else {
      wrong += !same_bits(value, float(expected));
      wrong += to_half(value).bits != bits;
    }
  }
  CHECK(wrong == 0);
}

TEST_CASE("half: floats of every magnitude and beside every tie round to the nearest, ties to even") {
  int wrong = 0;
  const auto check = [&](float value) { wrong += to_half(value).bits != nearest_half(value); };
  Random random(1);
  for (int i = 0; i < 200'000; ++i) {
    check(std::bit_cast<float>(std::uint32_t(random.bits() >> 32)));
    check(float(random.scale(1e-9, 2e5)) * (i % 2 ? 1.0f : -1.0f));
  }
  for (std::uint16_t bits = 0; bits <= 0x7bff; ++bits) {
    const double next = bits == 0x7bff ? 65536 : value_of(std::uint16_t(bits + 1));  // which is infinite
    const float tie = float(0.5 * (value_of(bits) + next));
    for (const float value : {tie, std::nextafter(tie, 0.0f), std::nextafter(tie, INFINITY)})
      check(value), check(-value);
  }
  CHECK(wrong == 0);
}

}  // namespace swiftgs::test::half_test
