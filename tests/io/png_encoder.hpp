// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include <zlib.h>

#include "files.hpp"

namespace swiftgs::test {

inline std::string big_endian(std::uint32_t value) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += char(value >> shift & 255);
  return bytes;
}

inline std::string png_chunk(const std::string& type, const std::string& data) {
  const std::string body = type + data;
  const auto check = std::uint32_t(crc32(0, reinterpret_cast<const Bytef*>(body.data()), uInt(body.size())));
  return big_endian(std::uint32_t(data.size())) + body + big_endian(check);
}

/// Colour types of PNG.
enum PngColour : char { png_grey = 0, png_rgb = 2, png_palette = 3, png_grey_alpha = 4, png_rgba = 6 };

struct PngParts {
  std::uint32_t width = 1, height = 1;
  char bits = 8;
  PngColour colour = png_rgb;
  std::string rows{};         ///< each behind a filter byte of 0
  std::string before_rows{};  ///< chunks such as a palette
};

inline std::string png(const PngParts& parts) {
  std::string packed(compressBound(uLong(parts.rows.size())), '\0');
  uLongf size = uLongf(packed.size());
  REQUIRE(compress(reinterpret_cast<Bytef*>(packed.data()), &size,
                   reinterpret_cast<const Bytef*>(parts.rows.data()), uLong(parts.rows.size())) == Z_OK);
  packed.resize(size);
  const std::string settings{parts.bits, char(parts.colour), 0, 0, 0};
  return "\x89PNG\r\n\x1a\n" +
         png_chunk("IHDR", big_endian(parts.width) + big_endian(parts.height) + settings) +
         parts.before_rows + png_chunk("IDAT", packed) + png_chunk("IEND", "");
}

}  // namespace swiftgs::test
