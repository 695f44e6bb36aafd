// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "image_parsing.hpp"

/// @file
/// The images of a SOG, which hold bytes and no colours.

namespace swiftgs::io {

/// Pixels of four bytes, rows from top to bottom.
using RgbaPixels = std::unique_ptr<std::uint8_t[]>;

/// The size that an image's header states. Throws `FormatError` unless it is a lossless WebP or a PNG.
ImageSize sog_image_size(const Source& source);

/// All bytes as they were stored: alpha is a number too, and multiplied with nothing. `size` is what
/// `sog_image_size` said.
RgbaPixels decode_sog_image(const Source& source, ImageSize size);

}  // namespace swiftgs::io
