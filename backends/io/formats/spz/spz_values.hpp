// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <swiftgs/math.hpp>

#include "spz_content.hpp"

/// @file
/// The quantised values of SPZ, decoded and activated.

namespace swiftgs::io {

/// What each byte stands for.
struct SpzTables {
  SpzTables();

  static vec3 three(const std::array<float, 256>& table, const std::byte* at);

  std::array<float, 256> colour;  ///< SH coefficient of band 0
  std::array<float, 256> scale;   ///< standard deviation
};

/// A position in the axes of the file. Version 1 holds halves, the others 24-bit fixed point.
vec3 decode_spz_position(const SpzHeader& header, const std::byte* at);

float decode_spz_opacity(const std::byte* at);

/// Two bits name the largest of x, y, z, w; the others have ten bits each, the first of them the highest.
Quaternion decode_smallest_three(std::uint32_t packed);

/// A unit quaternion in the axes of the file. Versions 1 and 2 hold x, y, z; the others the smallest three.
Quaternion decode_spz_rotation(const SpzHeader& header, const std::byte* at);

}  // namespace swiftgs::io
