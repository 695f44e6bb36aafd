// SPDX-License-Identifier: Apache-2.0

#include <cmath>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <string>
#include <type_traits>
#include <vector>

#include <swiftgs/camera.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/render_input.hpp>
#include <swiftgs/io/image.hpp>
#include <swiftgs/raster/store.hpp>

#include "image_parsing.hpp"
#include "mapped_file.hpp"
#include "output_file.hpp"
#include "text.hpp"

namespace swiftgs {
namespace io {

namespace {

bool is_png(const Source& source) { return source.text().starts_with("\x89PNG\r\n\x1a\n"); }
bool is_jpeg(const Source& source) { return source.text().starts_with("\xff\xd8\xff"); }

}  // namespace

ImageSize image_size(const Source& source) {
  if (is_png(source)) return png_size(source);
  if (is_jpeg(source)) return jpeg_size(source);
  const Image image = read_image(source.bytes, source.name);
  return {image.width, image.height};
}

void expect_plausible_size(const Source& source, std::uint64_t offset, std::uint64_t width,
                           std::uint64_t height, std::uint64_t most_pixels_per_byte) {
  if (width < 1 || height < 1 || width > max_image_side || height > max_image_side)
    source.fail(offset, "an image of 1 to " + std::to_string(max_image_side) + " pixels a side");
  if (width * height / most_pixels_per_byte > source.bytes.size())
    source.fail(offset, "a file that can hold " + std::to_string(width) + "x" + std::to_string(height) +
                            " pixels, found " + std::to_string(source.bytes.size()) + " bytes");
}

void expect_colour(const Frame& frame) {
  if (frame.width < 1 || frame.height < 1 || frame.colour.size() != 3 * frame.pixels())
    throw InvalidArgument("image: expected a frame with colour");
}

}  // namespace io

Image read_image(std::span<const std::byte> bytes, const std::string& name) {
  const io::Source source{bytes, name};
  const std::string_view text = source.text();
  if (io::is_png(source)) return io::parse_png(source);
  if (io::is_jpeg(source)) return io::parse_jpeg(source);
  if (text.starts_with("PF") || text.starts_with("Pf")) return io::parse_pfm(source);
  if (text.starts_with("\x76\x2f\x31\x01")) return io::parse_exr(source);
  source.fail(0, "an image: PNG, JPEG, PFM or EXR");
}

Image read_image(const std::filesystem::path& path) {
  const io::MappedFile file(path);
  return read_image(file.bytes(), path.string());
}

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

namespace io {

Image parse_pfm(const Source& source) {
  Tokens tokens(source.text());
  const std::string_view kind = tokens.next(), width = tokens.next(), height = tokens.next();
  std::uint64_t columns = 0, rows = 0;
  float scale = 0;
  if ((kind != "PF" && kind != "Pf") || !to_number(width, columns) || !to_number(height, rows) ||
      !to_number(tokens.next(), scale) || !std::isfinite(scale) || scale == 0)
    source.fail(0, "a PFM header ('PF' or 'Pf', width, height, scale)");
  const std::uint64_t start = tokens.position() + 1;  // one blank ends the header
  expect_plausible_size(source, 0, columns, rows, 1);
  Image image{.width = int(columns), .height = int(rows), .channels = kind == "PF" ? 3 : 1};
  const std::size_t row_values = std::size_t(image.width) * image.channels;
  const std::size_t values = row_values * image.height;
  if (source.bytes.size() < start || source.bytes.size() - start != values * sizeof(float))
    source.fail(start, std::to_string(values * sizeof(float)) + " bytes of pixels up to the end of the file");

  // The bottom row comes first, and the scale's sign is the byte order.
  const std::endian order = scale < 0 ? std::endian::little : std::endian::big;
  image.pixels.resize(values);
  for (std::size_t row = 0; row < std::size_t(image.height); ++row) {
    const std::byte* from = source.bytes.data() + start + row * row_values * sizeof(float);
    float* to = image.pixels.data() + (image.height - 1 - row) * row_values;
    for (std::size_t i = 0; i < row_values; ++i)
      to[i] = load<float>(from + i * sizeof(float), order) * std::abs(scale);
  }
  return image;
}

}  // namespace io

void write_pfm(const std::filesystem::path& path, const Frame& frame) {
  io::expect_colour(frame);
  io::OutputFile file(path);
  const bool little = std::endian::native == std::endian::little;
  const std::string header = "PF\n" + std::to_string(frame.width) + " " + std::to_string(frame.height) +
                             (little ? "\n-1.0\n" : "\n1.0\n");
  file.write(header.data(), header.size());
  const std::size_t row_values = 3 * std::size_t(frame.width);
  for (int row = frame.height - 1; row >= 0; --row)
    file.write(frame.colour.data() + row * row_values, row_values * sizeof(float));
  file.close();
}

}  // namespace swiftgs
