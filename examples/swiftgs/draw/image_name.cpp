// SPDX-License-Identifier: Apache-2.0
#include "draw/image_name.hpp"

#include <algorithm>
#include <iterator>
#include <string>

namespace swiftgs::cli {
namespace {

constexpr std::string_view endings[] = {"arw",  "avif", "bmp",  "cr2", "cr3", "dng", "exr",  "gif",
                                        "heic", "heif", "jpeg", "jpg", "jxl", "nef", "orf",  "pfm",
                                        "png",  "ppm",  "raw",  "rw2", "tga", "tif", "tiff", "webp"};

}  // namespace

std::string_view without_extension(std::string_view name) {
  const std::size_t dot = name.rfind('.'), slash = name.find_last_of("/\\");
  const bool has = dot != name.npos && dot > 0 && (slash == name.npos || dot > slash + 1);
  if (!has) return name;
  std::string ending(name.substr(dot + 1));
  for (char& c : ending)
    if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
  const bool known = std::find(std::begin(endings), std::end(endings), ending) != std::end(endings);
  return known ? name.substr(0, dot) : name;
}

}  // namespace swiftgs::cli
