// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <stdexcept>

#include <swiftgs/io/image.hpp>
#include <swiftgs/metrics.hpp>

#include "commands.hpp"
#include "json.hpp"

namespace swiftgs::cli {
namespace {

/// Drops alpha: colours are compared.
Image colour_of(Image image) {
  const int channels = image.channels >= 3 ? 3 : 1;
  if (image.channels == channels) return image;
  Image colour{image.width, image.height, channels, {}};
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    if (int(i % std::size_t(image.channels)) < channels) colour.pixels.push_back(image.pixels[i]);
  return colour;
}

std::string shape_of(const Image& image) {
  return std::to_string(image.width) + "x" + std::to_string(image.height) + " " +
         (image.channels == 1 ? "grey" : "RGB");
}

}  // namespace

void compare(const CompareOptions& options) {
  const Image a = colour_of(read_image(options.a)), b = colour_of(read_image(options.b));
  if (shape_of(a) != shape_of(b))
    throw std::invalid_argument(options.b + ": expected " + shape_of(a) + " as in " + options.a + ", found " +
                                shape_of(b));
  const Comparison comparison{psnr(a.pixels, b.pixels),
                              ssim(a.width, a.height, a.channels, a.pixels, b.pixels),
                              max_abs_difference(a.pixels, b.pixels)};
  std::printf("%s\n", to_json(comparison).c_str());
}

}  // namespace swiftgs::cli
