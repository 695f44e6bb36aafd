// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>

#include "files.hpp"
#include "ply_compressed.hpp"

using namespace swiftgs;
using namespace swiftgs::io;

TEST_CASE("compressed ply: fractions keep their bits and are rounded to the nearest") {
  std::mt19937 random(1);
  for (int i = 0; i < 1000; ++i) {
    const auto word = std::uint32_t(random());
    CHECK(pack_fractions(unpack_fractions(word)) == word);
  }
  CHECK(unpack_fractions(0xffffffff) == dvec3(1.0));
  CHECK(pack_fractions({1.4 / 2047, 1.4 / 1023, 1.4 / 2047}) == (1u << 21 | 1u << 11 | 1u));
  CHECK(pack_fractions({1.6 / 2047, 1.6 / 1023, 1.6 / 2047}) == (2u << 21 | 2u << 11 | 2u));
}

TEST_CASE("compressed ply: rotations come back within half a step whichever component is largest") {
  std::mt19937 random(2);
  std::normal_distribution<double> value;
  const double half_step = std::sqrt(2.0) / 1023 / 2 + 1e-7;
  for (int i = 0; i < 4000; ++i) {
    std::array<double, 4> q = {value(random), value(random), value(random), value(random)};
    q[std::size_t(i % 4)] *= 8;
    const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    const Quaternion unit{float(q[0] / length), float(q[1] / length), float(q[2] / length),
                          float(q[3] / length)};
    const Quaternion back = unpack_rotation(pack_rotation(unit));
    const std::array<float, 4> a = {unit.w, unit.x, unit.y, unit.z}, b = {back.w, back.x, back.y, back.z};
    const auto smaller = [](float c, float d) { return std::abs(c) < std::abs(d); };
    const auto largest = std::size_t(std::max_element(a.begin(), a.end(), smaller) - a.begin());
    CHECK(b[largest] > 0);
    for (std::size_t k = 0; k < 4; ++k)
      if (k != largest) REQUIRE(std::abs(b[k] - std::copysign(1.0f, a[largest]) * a[k]) <= half_step);
  }
}

TEST_CASE("compressed ply: rotations are w first and the identity is nearly itself") {
  const std::uint32_t third = 1u << 30 | 512u << 20 | 512u << 10 | 512u;  // x is the largest
  CHECK(unpack_rotation(third).x > 0.999f);
  CHECK(unpack_rotation(512u << 20 | 512u << 10 | 512u).w > 0.999f);
  const Quaternion too_long = unpack_rotation(0x3fffffff);  // three components of sqrt(1/2)
  CHECK(too_long.w == 0);
  CHECK(too_long.x == doctest::Approx(1 / std::sqrt(3.0)));
}

TEST_CASE("compressed ply: every harmonic gets the byte whose value is nearest") {
  for (int byte = 0; byte < 256; ++byte) CHECK(pack_sh(unpack_sh(std::uint8_t(byte)), byte % 3 == 0) == byte);
  CHECK(pack_sh(0, true) == 127);
  CHECK(pack_sh(0, false) == 128);
  for (int step = -5000; step <= 5000; ++step) {
    const float value = float(step) / 1001;
    float least = 100;
    for (int byte = 0; byte < 256; ++byte)
      least = std::min(least, std::abs(unpack_sh(std::uint8_t(byte)) - value));
    for (const bool lower : {false, true})
      REQUIRE(std::abs(unpack_sh(pack_sh(value, lower)) - value) == least);
  }
}
