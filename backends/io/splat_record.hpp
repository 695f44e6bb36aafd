// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "scene_building.hpp"

/// @file
/// A `.splat` file is records of 32 bytes: mean and scales (3 floats each, the scales not logarithms), red,
/// green, blue and opacity (a byte each, 255 is 1), and the rotation w, x, y, z (a byte each, 128 is 0 and
/// 0 is -1, as the format's first viewer reads them). Some writers truncate where that viewer's own rounds;
/// no file says which.

namespace swiftgs::io {

inline constexpr std::size_t splat_record_bytes = 32;

/// The SH coefficient of band 0 that a byte of a colour stands for.
inline float sh0_of_splat(std::uint8_t byte) { return float((double(byte) / 255 - 0.5) / sh_c0); }

}  // namespace swiftgs::io
