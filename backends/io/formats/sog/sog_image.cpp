// SPDX-License-Identifier: Apache-2.0
#include "sog_image.hpp"

#include <cmath>
#include <string>

#include <webp/decode.h>

namespace swiftgs::io {
namespace {

bool is_png(const Source& source) { return source.text().starts_with("\x89PNG"); }

const std::uint8_t* data_of(const Source& source) {
  return reinterpret_cast<const std::uint8_t*>(source.bytes.data());
}

void decode_png(const Source& source, std::uint8_t* rgba) {
  const Image image = parse_png(source);
  const bool grey = image.channels < 3, opaque = image.channels % 2 == 1;
  const float* from = image.pixels.data();
  const auto byte = [](float value) { return std::uint8_t(std::lround(value * 255)); };
  const std::size_t pixels = std::size_t(image.width) * image.height;
  for (std::size_t i = 0; i < pixels; ++i, from += image.channels, rgba += 4) {
    for (int c = 0; c < 3; ++c) rgba[c] = byte(from[grey ? 0 : c]);
    rgba[3] = opaque ? 255 : byte(from[image.channels - 1]);
  }
}

}  // namespace

ImageSize sog_image_size(const Source& source) {
  if (is_png(source)) return png_size(source);
  WebPBitstreamFeatures features;
  if (WebPGetFeatures(data_of(source), source.bytes.size(), &features) != VP8_STATUS_OK)
    source.fail(0, "a WebP or a PNG image");
  constexpr int lossless = 2;
  if (features.has_animation || features.format != lossless)
    source.fail(0, std::string("a lossless WebP, found ") +
                       (features.has_animation ? "an animation" : "a lossy one"));
  return {features.width, features.height};
}

RgbaPixels decode_sog_image(const Source& source, ImageSize size) {
  const std::size_t bytes = std::size_t(size.width) * size.height * 4;
  auto rgba = std::make_unique_for_overwrite<std::uint8_t[]>(bytes);
  if (is_png(source))
    decode_png(source, rgba.get());
  else if (!WebPDecodeRGBAInto(data_of(source), source.bytes.size(), rgba.get(), bytes, size.width * 4))
    source.fail(source.bytes.size(), "a whole WebP image, found damaged data or too few bytes");
  return rgba;
}

}  // namespace swiftgs::io
