// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <png.h>

#include <swiftgs/error.hpp>

#include "image_parsing.hpp"
#include "output_file.hpp"

namespace swiftgs {
namespace {

std::uint8_t to_byte(float value) {
  if (!(value > 0)) return 0;  // NaN too
  return value >= 1 ? 255 : std::uint8_t(std::lround(value * 255));
}

/// `name` begins the message of an error.
std::vector<std::byte> encode(const Frame& frame, const std::string& name) {
  io::expect_colour(frame);
  const bool has_alpha = frame.alpha.size() == frame.pixels();
  std::vector<std::uint8_t> bytes;
  bytes.reserve((has_alpha ? 4 : 3) * frame.pixels());
  for (std::size_t pixel = 0; pixel < frame.pixels(); ++pixel) {
    const float alpha = has_alpha ? frame.alpha[pixel] : 1.0f;
    for (std::size_t c = 0; c < 3; ++c) bytes.push_back(to_byte(frame.colour[3 * pixel + c] / alpha));
    if (has_alpha) bytes.push_back(to_byte(alpha));
  }

  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = png_uint_32(frame.width);
  image.height = png_uint_32(frame.height);
  image.format = has_alpha ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB;
  std::vector<std::byte> encoded(PNG_IMAGE_PNG_SIZE_MAX(image));
  png_alloc_size_t size = encoded.size();
  if (!png_image_write_to_memory(&image, encoded.data(), &size, 0, bytes.data(), 0, nullptr))
    throw Unavailable(name + ": PNG encoder: " + image.message);
  encoded.resize(size);
  return encoded;
}

}  // namespace

std::vector<std::byte> encode_png(const Frame& frame) { return encode(frame, "image"); }

void write_png(const std::filesystem::path& path, const Frame& frame) {
  const std::vector<std::byte> encoded = encode(frame, path.string());
  io::OutputFile file(path);
  file.write(encoded.data(), encoded.size());
  file.close();
}

}  // namespace swiftgs
