// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstring>
#include <memory>
#include <string_view>
#include <vector>

#include <name_ending.hpp>

#include <swiftgs/c/view.h>
#include <swiftgs/frame.hpp>
#include <swiftgs/io/image.hpp>
#include <swiftgs/render_input.hpp>

#include "error.hpp"
#include "structs.hpp"
#include "view.hpp"

struct swiftgs_picture {
  swiftgs::Image image;
};

namespace swiftgs::c {
namespace {

using Writer = void (*)(const std::filesystem::path& path, const Frame& frame);

Writer writer_of(std::string_view path) {
  if (io::has_ending(path, ".png")) return &write_png;
  if (io::has_ending(path, ".pfm")) return &write_pfm;
  if (io::has_ending(path, ".exr")) return &write_exr;
  refuse(path, ": expected a name that ends in .png, .pfm or .exr");
}

/// The rows of a plane, one behind the other.
template <class T>
void copy(const swiftgs_plane& from, std::size_t row, std::size_t rows, std::vector<T>& to) {
  const auto plane = to_plane<const T>(from);
  if (!plane.data) return;
  to.resize(row * rows);
  for (std::size_t y = 0; y < rows; ++y) std::memcpy(&to[y * row], plane.row(y), row * sizeof(T));
}

Frame to_frame(const swiftgs_image& from) {
  require_pointer(from.colour.data, "swiftgs_image: colour");
  FrameView view{.width = from.width, .height = from.height};
  set_planes(view, from);
  validate(view);
  Frame frame;
  frame.width = from.width, frame.height = from.height, frame.feature_channels = from.feature_channels;
  for_each_plane(
      [&](std::size_t channels, const swiftgs_plane& plane, auto& to) {
        copy(plane, channels * std::size_t(from.width), std::size_t(from.height), to);
      },
      from, frame);
  return frame;
}

}  // namespace
}  // namespace swiftgs::c

using namespace swiftgs::c;

extern "C" {

swiftgs_status swiftgs_image_write(const char* path, const swiftgs_image* image) {
  return guarded([&] {
    require_pointer(path, "path");
    const Writer write = writer_of(path);
    write(path, to_frame(read_struct(image, "swiftgs_image")));
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
