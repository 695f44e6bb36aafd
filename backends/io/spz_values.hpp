// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

#include <swiftgs/math.hpp>

#include "spz_content.hpp"

/// @file
/// The quantised values of SPZ, decoded and activated.

namespace swiftgs::io {

/// What each byte stands for.
struct SpzTables {
  SpzTables();

  std::array<float, 256> colour;  ///< SH coefficient of band 0
  std::array<float, 256> scale;   ///< standard deviation
  std::array<float, 256> sh;      ///< SH coefficient above band 0
};

/// A position in the axes of the file. Version 1 holds halves, the others 24-bit fixed point.
vec3 decode_spz_position(const SpzHeader& header, const std::byte* at);

/// A unit quaternion in the axes of the file. Versions 1 and 2 hold x, y, z; the others the smallest three.
Quaternion decode_spz_rotation(const SpzHeader& header, const std::byte* at);

}  // namespace swiftgs::io
