// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <swiftgs/io/image.hpp>

#include "bytes.hpp"

/// @file
/// Image files in memory, and the checks that all of them share.

namespace swiftgs::io {

Image parse_png(const Source& source);
Image parse_jpeg(const Source& source);
Image parse_pfm(const Source& source);
Image parse_exr(const Source& source);

/// Sides of an image, legal ones.
struct ImageSize {
  int width, height;
};

/// The size of an image of any of these formats. Of PNG and JPEG only the header is read.
ImageSize image_size(const Source& source);

ImageSize png_size(const Source& source);
ImageSize jpeg_size(const Source& source);

/// Throws `FormatError` at `offset` unless the sides are legal and `source` can hold that many pixels, given
/// the most that its compression packs into a byte. Asked before memory is taken for them.
void expect_plausible_size(const Source& source, std::uint64_t offset, std::uint64_t width,
                           std::uint64_t height, std::uint64_t most_pixels_per_byte);

/// Throws `InvalidArgument` unless `frame` has colour of its size.
void expect_colour(const Frame& frame);

}  // namespace swiftgs::io
