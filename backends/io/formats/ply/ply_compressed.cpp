// SPDX-License-Identifier: Apache-2.0
#include "ply_compressed.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <swiftgs/activation.hpp>

#include "scene_building.hpp"

namespace swiftgs::io {
namespace {

std::uint32_t nearest(double fraction, std::uint32_t most) {
  return std::uint32_t(std::clamp(fraction, 0.0, 1.0) * most + 0.5);
}

dvec3 within(const Range3& range, dvec3 fraction) {
  return dvec3(range.low) * (1.0 - fraction) + dvec3(range.high) * fraction;
}

}  // namespace

std::uint32_t pack_fractions(dvec3 fractions) {
  return nearest(fractions.x, 2047) << 21 | nearest(fractions.y, 1023) << 11 | nearest(fractions.z, 2047);
}

dvec3 unpack_fractions(std::uint32_t packed) {
  return {double(packed >> 21) / 2047, double(packed >> 11 & 1023) / 1023, double(packed & 2047) / 2047};
}

std::uint32_t pack_rotation(Quaternion unit) {
  const std::array<double, 4> q = {unit.w, unit.x, unit.y, unit.z};
  const auto smaller = [](double a, double b) { return std::abs(a) < std::abs(b); };
  const auto largest = std::size_t(std::max_element(q.begin(), q.end(), smaller) - q.begin());
  // The negative quaternion is the same rotation, and a largest component that is positive needs no sign.
  const double scale = std::copysign(1 / std::numbers::sqrt2, q[largest]);
  auto packed = std::uint32_t(largest);
  for (std::size_t i = 0; i < 4; ++i)
    if (i != largest) packed = packed << 10 | nearest(q[i] * scale + 0.5, 1023);
  return packed;
}

Quaternion unpack_rotation(std::uint32_t packed) {
  const std::size_t largest = packed >> 30;
  std::array<double, 4> q{};
  double squared = 0;
  for (std::size_t i = 0, shift = 20; i < 4; ++i) {
    if (i == largest) continue;
    q[i] = (double(packed >> shift & 1023) / 1023 - 0.5) * std::numbers::sqrt2;
    squared += q[i] * q[i];
    shift -= 10;
  }
  q[largest] = std::sqrt(std::max(0.0, 1 - squared));
  return normalised(float(q[0]), float(q[1]), float(q[2]), float(q[3]));
}

Vertex unpacked(const PackedVertex& packed, const ChunkRanges& ranges) {
  const auto [position, rotation, scale, colour_and_opacity] = packed;
  const dvec3 log_scale = within(ranges.log_scale, unpack_fractions(scale));
  const auto byte = [&, word = colour_and_opacity](int shift) { return double(word >> shift & 255); };
  const dvec3 colour = within(ranges.colour, dvec3(byte(24), byte(16), byte(8)) / 255.0);
  return {.mean = vec3(within(ranges.mean, unpack_fractions(position))),
          .scale = vec3(std::exp(log_scale.x), std::exp(log_scale.y), std::exp(log_scale.z)),
          .sh0 = vec3((colour - 0.5) / sh_c0),
          .rotation = unpack_rotation(rotation),
          .opacity = float(byte(0)) / 255};
}

std::uint8_t pack_sh(float coefficient, bool lower) {
  const double at = double(coefficient) * 32 + 128;
  // Bytes 0 and 255 stand for 0 and 256, which is further from their neighbours' 1.5 and 254.5 than 1.
  if (at < 0.75) return 0;
  if (at >= 255.25) return 255;
  const bool tie = at == std::floor(at) && at >= 2 && at <= 254;
  return std::uint8_t(std::clamp(at - (tie && lower ? 1 : 0), 1.0, 254.0));
}

float unpack_sh(std::uint8_t packed) {
  if (packed == 0) return -4;
  return packed == 255 ? 4 : (float(packed) + 0.5f) / 32 - 4;
}

}  // namespace swiftgs::io
