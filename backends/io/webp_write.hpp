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

/// Encodes lossless WebP and keeps the colours of transparent pixels. The same image gives the same file.
/// After `stopping` it returns early, with part of the file.
std::string encode_webp(const RgbaImage& image, const Stopping& stopping);

}  // namespace swiftgs::io
