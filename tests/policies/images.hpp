// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Images in the caller's memory, in every pixel format.

#include <cstddef>
#include <vector>

#include <swiftgs/frame.hpp>
#include <swiftgs/raster/store.hpp>

#include "policies/random_splats.hpp"

namespace swiftgs::test {

/// Pixels of a format, with bytes behind each row that belong to nobody.
struct Image {
  static constexpr unsigned char nobodys = 0xa5;

  Image(int width_, int height_, PixelFormat format_)
      : width(width_),
        height(height_),
        format(format_),
        pitch(bytes_per_pixel(format_) * std::size_t(width_) + 24),
        bytes(pitch * std::size_t(height_), nobodys) {}

  FrameView frame() {
    return {
        .width = width, .height = height, .colour = {bytes.data(), std::ptrdiff_t(pitch)}, .format = format};
  }
  vec4 at(int x, int y) { return detail::load_colour(frame(), std::size_t(x), std::size_t(y)); }
  void set(int x, int y, vec4 colour) {
    detail::store_colour(frame(), std::size_t(x), std::size_t(y), colour);
  }
  bool kept_to_its_rows() const {
    const std::size_t used = bytes_per_pixel(format) * std::size_t(width);
    for (std::size_t i = 0; i < bytes.size(); ++i)
      if (i % pitch >= used && bytes[i] != nobodys) return false;
    return true;
  }

  int width, height;
  PixelFormat format;
  std::size_t pitch;
  std::vector<unsigned char> bytes;
};

inline constexpr PixelFormat pixel_formats[] = {PixelFormat::rgb_float, PixelFormat::rgba_float,
                                                PixelFormat::rgba_half, PixelFormat::rgba_8,
                                                PixelFormat::bgra_8};

/// `image` in another format.
inline Image converted(Image image, PixelFormat format) {
  Image out(image.width, image.height, format);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) out.set(x, y, image.at(x, y));
  return out;
}

/// Colours that each format holds exactly, of every opacity.
inline Image pattern(int width, int height, PixelFormat format) {
  Random random(21);
  Image image(width, height, format);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      image.set(x, y, {random.f(0, 1), random.f(0, 1), random.f(0, 1), x % 3 == 0 ? 1.0f : random.f(0, 1)});
  return image;
}

}  // namespace swiftgs::test
