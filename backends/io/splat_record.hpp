// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

/// @file
/// A `.splat` file is records of 32 bytes: mean and scales (3 floats each, the scales not logarithms), red,
/// green, blue and opacity (a byte each, 255 is 1), and the rotation w, x, y, z (a byte each, 128 is 0 and
/// 0 is -1, as the format's first viewer reads them). Some writers truncate where that viewer's own rounds;
/// no file says which.

namespace swiftgs::io {

inline constexpr std::size_t splat_record_bytes = 32;

}  // namespace swiftgs::io
