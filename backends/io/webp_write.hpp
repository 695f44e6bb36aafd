// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "tasks.hpp"

namespace swiftgs::io {

/// Four bytes a pixel, red first, rows from top to bottom.
struct RgbaImage {
  std::size_t width = 0, height = 0;
  std::vector<std::uint8_t> bytes{};
};

inline constexpr std::size_t most_webp_pixels_a_side = 16383;

/// As lossless WebP, bytes of transparent pixels included. The same image gives the same file. Returns early,
/// with part of the file, once it is to stop.
std::string encode_webp(const RgbaImage& image, const Stopping& stopping);

}  // namespace swiftgs::io
