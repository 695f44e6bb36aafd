// SPDX-License-Identifier: Apache-2.0
// Takes the place of exr.cpp in a build without OpenEXR.

#include <swiftgs/error.hpp>

#include "image_parsing.hpp"

namespace swiftgs {

Image io::parse_exr(const Source& source) {
  source.fail(0, "a PNG, JPEG or PFM image, found an EXR: this build is without OpenEXR");
}

void write_exr(const std::filesystem::path& path, const Frame&) {
  throw Unavailable(path.string() + ": EXR cannot be written: this build is without OpenEXR");
}

}  // namespace swiftgs
