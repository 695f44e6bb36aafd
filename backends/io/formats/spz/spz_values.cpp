// SPDX-License-Identifier: Apache-2.0
#include "spz_values.hpp"

#include <algorithm>
#include <cmath>

#include <swiftgs/activation.hpp>

#include "half_float.hpp"

namespace swiftgs::io {
namespace {

/// Little-endian two's complement; exact in a float.
float int24_to_float(const std::byte* at) {
  const auto byte = [&](int i) { return std::to_integer<std::int32_t>(at[i]); };
  const std::int32_t value = byte(0) | byte(1) << 8 | byte(2) << 16;
  return float(value >= 1 << 23 ? value - (1 << 24) : value);
}

Quaternion decode_xyz(const std::byte* at) {
  const auto component = [&](int i) { return float(std::to_integer<int>(at[i])) / 127.5f - 1; };
  const float x = component(0), y = component(1), z = component(2);
  return normalised(std::sqrt(std::max(0.0f, 1 - x * x - y * y - z * z)), x, y, z);
}

}  // namespace

SpzTables::SpzTables() {
  for (int byte = 0; byte < 256; ++byte) {
    colour[byte] = (float(byte) / 255 - 0.5f) / 0.15f;
    scale[byte] = std::exp(float(byte) / 16 - 10);
  }
}

vec3 SpzTables::three(const std::array<float, 256>& table, const std::byte* at) {
  return {table[std::to_integer<std::size_t>(at[0])], table[std::to_integer<std::size_t>(at[1])],
          table[std::to_integer<std::size_t>(at[2])]};
}

float decode_spz_opacity(const std::byte* at) { return float(std::to_integer<int>(*at)) / 255; }

vec3 decode_spz_position(const SpzHeader& header, const std::byte* at) {
  if (header.version == 1) {
    const auto half = [&](int i) { return half_to_float(load<std::uint16_t>(at + 2 * i)); };
    return {half(0), half(1), half(2)};
  }
  const float unit = 1 / float(1u << header.fractional_bits);
  return {unit * int24_to_float(at), unit * int24_to_float(at + 3), unit * int24_to_float(at + 6)};
}

Quaternion decode_smallest_three(std::uint32_t packed) {
  const int largest = int(packed >> 30);
  std::array<float, 4> xyzw;
  float squares = 0;
  for (int i = 3; i >= 0; --i) {
    if (i == largest) continue;
    const float magnitude = float(packed & 511) / 511 * float(std::sqrt(0.5));
    xyzw[i] = packed & 512 ? -magnitude : magnitude;
    squares += magnitude * magnitude;
    packed >>= 10;
  }
  xyzw[largest] = std::sqrt(std::max(0.0f, 1 - squares));
  return normalised(xyzw[3], xyzw[0], xyzw[1], xyzw[2]);
}

Quaternion decode_spz_rotation(const SpzHeader& header, const std::byte* at) {
  return header.version < 3 ? decode_xyz(at) : decode_smallest_three(load<std::uint32_t>(at));
}

}  // namespace swiftgs::io
