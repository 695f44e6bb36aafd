// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdint>

#include <png.h>

#include "image_parsing.hpp"
#include "output_file.hpp"

namespace swiftgs {
namespace {

std::uint8_t to_byte(float value) {
  if (!(value > 0)) return 0;  // NaN too
  return value >= 1 ? 255 : std::uint8_t(std::lround(value * 255));
}

}  // namespace

void write_png(const std::filesystem::path& path, const Frame& frame) {
  io::expect_colour(frame);
  std::vector<std::uint8_t> bytes;
  bytes.reserve(frame.colour.size());
  for (const float value : frame.colour) bytes.push_back(to_byte(value));

  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = png_uint_32(frame.width);
  image.height = png_uint_32(frame.height);
  image.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> encoded(PNG_IMAGE_PNG_SIZE_MAX(image));
  png_alloc_size_t size = encoded.size();
  if (!png_image_write_to_memory(&image, encoded.data(), &size, 0, bytes.data(), 0, nullptr))
    throw std::runtime_error(path.string() + ": PNG encoder: " + image.message);
  io::OutputFile file(path);
  file.write(encoded.data(), size);
  file.close();
}

}  // namespace swiftgs
