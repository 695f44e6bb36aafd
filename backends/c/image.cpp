// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <memory>
#include <string_view>

#include <name_ending.hpp>

#include <swiftgs/c/view.h>
#include <swiftgs/frame.hpp>
#include <swiftgs/io/image.hpp>

#include "error.hpp"
#include "structs.hpp"
#include "view.hpp"

struct swiftgs_picture {
  swiftgs::Image image;
};

namespace swiftgs::c {
namespace {

/// A view to write, and the background behind it.
struct Picture {
  FrameView view;
  vec3 background;
};

Picture read_picture(const swiftgs_image* image) {
  const swiftgs_image from = read_struct(image, "swiftgs_image");
  require_pointer(from.colour.data, "swiftgs_image: colour");
  require_choice(from.format, format_count, "swiftgs_image: format");
  require_zero(from.reserved, "swiftgs_image");
  FrameView view{.width = from.width, .height = from.height, .format = PixelFormat(from.format)};
  set_planes(view, from);
  view.over = from.over != 0;
  return {view, vec3(from.background[0], from.background[1], from.background[2])};
}

void write(std::string_view path, const Picture& picture) {
  if (io::has_ending(path, ".png")) return write_png(path, picture.view, picture.background);
  if (io::has_ending(path, ".pfm")) return write_pfm(path, picture.view);
  if (io::has_ending(path, ".exr")) return write_exr(path, picture.view);
  refuse(path, ": expected a name that ends in .png, .pfm or .exr");
}

}  // namespace
}  // namespace swiftgs::c

using namespace swiftgs::c;

extern "C" {

swiftgs_status swiftgs_image_write(const char* path, const swiftgs_image* image) {
  return guarded([&] {
    require_pointer(path, "path");
    write(path, read_picture(image));
  });
}

swiftgs_status swiftgs_png_encode(const swiftgs_image* image, swiftgs_take_bytes take, void* context) {
  return guarded([&] {
    if (!take) refuse("take is NULL, expected a function");
    const Picture picture = read_picture(image);
    const auto bytes = swiftgs::encode_png(picture.view, picture.background);
    take(context, bytes.data(), bytes.size());
  });
}

swiftgs_status swiftgs_picture_read(const char* path, swiftgs_picture** picture) {
  return guarded([&] {
    require_pointer(path, "path");
    require_pointer(picture, "picture");
    *picture = std::make_unique<swiftgs_picture>(swiftgs_picture{swiftgs::read_image(path)}).release();
  });
}

swiftgs_status swiftgs_picture_get(const swiftgs_picture* picture, swiftgs_pixels* pixels) {
  return guarded([&] {
    require_pointer(picture, "picture");
    const swiftgs::Image& image = picture->image;
    write_struct(pixels, {0, image.width, image.height, image.channels, image.pixels.data()},
                 "swiftgs_pixels");
  });
}

void swiftgs_picture_free(swiftgs_picture* picture) { delete picture; }

}  // extern "C"
