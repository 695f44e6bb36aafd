// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <type_traits>
#include <vector>

#include <swiftgs/io/image.hpp>
#include <swiftgs/math.hpp>
#include <swiftgs/message.hpp>
#include <swiftgs/render_input.hpp>
#include <swiftgs/store_pixel.hpp>

namespace swiftgs {
namespace {

/// Copies the rows of a plane, if it is there.
template <class T>
void copy_rows(const FrameView& view, std::size_t channels, const Plane<T>& from, std::vector<T>& to) {
  if (!from.data) return;
  const std::size_t row = channels * std::size_t(view.width);
  to.resize(row * std::size_t(view.height));
  for (std::size_t y = 0; y < std::size_t(view.height); ++y)
    std::memcpy(&to[y * row], from.row(y), row * sizeof(T));
}

/// Copies RGB. The last channel of RGBA takes the place of `frame.alpha`: colours are multiplied by it.
void copy_colour(const FrameView& view, Frame& frame) {
  const bool has_alpha = view.format != PixelFormat::rgb_float;
  frame.colour.reserve(3 * view.pixels());
  if (has_alpha) frame.alpha.resize(view.pixels());
  for (std::size_t y = 0; y < std::size_t(view.height); ++y)
    for (std::size_t x = 0; x < std::size_t(view.width); ++x) {
      const vec4 pixel = detail::load_colour(view, x, y);
      for (int c = 0; c < 3; ++c) frame.colour.push_back(pixel[c]);
      if (has_alpha) frame.alpha[y * std::size_t(view.width) + x] = pixel.w;
    }
}

Frame copy_of(const FrameView& view) {
  if (!view.colour.data) detail::refuse("image: the view's colour is null, expected a plane in host memory");
  if (view.format < PixelFormat::rgb_float || view.format > PixelFormat::bgra_8)
    detail::refuse("image: the view's format is ", int(view.format), ", expected a PixelFormat");
  validate(view);
  Frame frame;
  frame.width = view.width, frame.height = view.height, frame.feature_channels = view.feature_channels;
  for_each_plane(
      [&]<class Source>(std::size_t channels, const Source& from, auto& to) {
        if constexpr (!std::is_same_v<Source, Plane<void>>) copy_rows(view, channels, from, to);
      },
      view, frame);
  copy_colour(view, frame);
  return frame;
}

/// The copy as a picture. What hides all behind it is opaque, whatever the splats' alpha.
Frame picture_of(const FrameView& view, vec3 background) {
  Frame frame = copy_of(view);
  const bool hides = view.over ? view.format == PixelFormat::rgb_float : background != vec3(0);
  if (hides) frame.alpha.clear();
  return frame;
}

}  // namespace

std::vector<std::byte> encode_png(const FrameView& view, vec3 background) {
  return encode_png(picture_of(view, background));
}

void write_png(const std::filesystem::path& path, const FrameView& view, vec3 background) {
  write_png(path, picture_of(view, background));
}

void write_pfm(const std::filesystem::path& path, const FrameView& view) { write_pfm(path, copy_of(view)); }

void write_exr(const std::filesystem::path& path, const FrameView& view) { write_exr(path, copy_of(view)); }

}  // namespace swiftgs
