// SPDX-License-Identifier: Apache-2.0

#include <cmath>
#include <csetjmp>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <new>
#include <string>
#include <vector>

#include <png.h>

#include <swiftgs/error.hpp>

#include "image_parsing.hpp"
#include "output_file.hpp"

namespace swiftgs::io {
namespace {

/// Everything that a decode needs. libpng jumps over frames, so no local variable may own memory.
struct PngDecode {
  const Source& source;
  std::size_t position = 0;
  std::string error{};
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::vector<std::uint16_t> samples{};  ///< 0 to 65535
  std::vector<png_bytep> rows{};

  ~PngDecode() { png_destroy_read_struct(&png, &info, nullptr); }
};

void on_error(png_structp png, png_const_charp message) {
  static_cast<PngDecode*>(png_get_error_ptr(png))->error = message;
  png_longjmp(png, 1);
}

void on_warning(png_structp, png_const_charp) {}

void on_read(png_structp png, png_bytep to, std::size_t size) {
  auto& decode = *static_cast<PngDecode*>(png_get_io_ptr(png));
  if (size > decode.source.bytes.size() - decode.position) png_error(png, "the file ends too early");
  std::memcpy(to, decode.source.bytes.data() + decode.position, size);
  decode.position += size;
}

/// Asks for samples of 16 bits in this machine's order, whatever the file holds.
void set_transformations(png_structp png) {
  png_set_expand_16(png);  // palettes, transparent colours and low bit depths too
  if constexpr (std::endian::native == std::endian::little) png_set_swap(png);
  png_set_interlace_handling(png);
}

/// False, with `decode.error` set, if libpng gave up.
bool read_header(PngDecode& decode) {
  if (setjmp(png_jmpbuf(decode.png))) return false;
  png_read_info(decode.png, decode.info);
  return true;
}

bool read_pixels(PngDecode& decode) {
  if (setjmp(png_jmpbuf(decode.png))) return false;
  png_read_image(decode.png, decode.rows.data());
  png_read_end(decode.png, nullptr);
  return true;
}

bool start_pixels(PngDecode& decode) {
  if (setjmp(png_jmpbuf(decode.png))) return false;
  set_transformations(decode.png);
  png_read_update_info(decode.png, decode.info);
  return true;
}

[[noreturn]] void fail(const PngDecode& decode) {
  decode.source.fail(decode.position, "a valid PNG (" + decode.error + ")");
}

/// Reads the header, and checks the size that it states.
ImageSize start_decode(PngDecode& decode) {
  decode.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &decode, on_error, on_warning);
  if (decode.png) decode.info = png_create_info_struct(decode.png);
  if (!decode.info) throw std::bad_alloc();
  png_set_read_fn(decode.png, &decode, on_read);
  if (!read_header(decode)) fail(decode);

  // A pixel may take a bit, and deflate packs 1032 to 1.
  const std::size_t width = png_get_image_width(decode.png, decode.info);
  const std::size_t height = png_get_image_height(decode.png, decode.info);
  expect_plausible_size(decode.source, 16, width, height, 8 * 1032);
  return {int(width), int(height)};
}

}  // namespace

ImageSize png_size(const Source& source) {
  PngDecode decode{source};
  return start_decode(decode);
}

Image parse_png(const Source& source) {
  PngDecode decode{source};
  const ImageSize size = start_decode(decode);
  const std::size_t width = size.width, height = size.height;
  if (!start_pixels(decode)) fail(decode);
  const std::size_t row_samples = width * png_get_channels(decode.png, decode.info);
  decode.samples.resize(height * row_samples);
  for (std::size_t row = 0; row < height; ++row)
    decode.rows.push_back(reinterpret_cast<png_bytep>(decode.samples.data() + row * row_samples));
  if (!read_pixels(decode)) fail(decode);

  Image image{.width = int(width), .height = int(height), .channels = int(row_samples / width)};
  image.pixels.reserve(decode.samples.size());
  for (const std::uint16_t sample : decode.samples) image.pixels.push_back(float(sample) / 65535);
  return image;
}

}  // namespace swiftgs::io

namespace swiftgs {
namespace {

std::uint8_t to_byte(float value) {
  if (!(value > 0)) return 0;  // NaN too
  return value >= 1 ? 255 : std::uint8_t(std::lround(value * 255));
}

/// `name` begins the message of an error.
std::vector<std::byte> encode(const Frame& frame, const std::string& name) {
  io::expect_colour(frame);
  const bool has_alpha = frame.alpha.size() == frame.pixels();
  std::vector<std::uint8_t> bytes;
  bytes.reserve((has_alpha ? 4 : 3) * frame.pixels());
  for (std::size_t pixel = 0; pixel < frame.pixels(); ++pixel) {
    const float alpha = has_alpha ? frame.alpha[pixel] : 1.0f;
    for (std::size_t c = 0; c < 3; ++c) bytes.push_back(to_byte(frame.colour[3 * pixel + c] / alpha));
    if (has_alpha) bytes.push_back(to_byte(alpha));
  }

  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = png_uint_32(frame.width);
  image.height = png_uint_32(frame.height);
  image.format = has_alpha ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB;
  std::vector<std::byte> encoded(PNG_IMAGE_PNG_SIZE_MAX(image));
  png_alloc_size_t size = encoded.size();
  if (!png_image_write_to_memory(&image, encoded.data(), &size, 0, bytes.data(), 0, nullptr))
    throw Unavailable(name + ": PNG encoder: " + image.message);
  encoded.resize(size);
  return encoded;
}

}  // namespace

std::vector<std::byte> encode_png(const Frame& frame) { return encode(frame, "image"); }

void write_png(const std::filesystem::path& path, const Frame& frame) {
  const std::vector<std::byte> encoded = encode(frame, path.string());
  io::OutputFile file(path);
  file.write(encoded.data(), encoded.size());
  file.close();
}

}  // namespace swiftgs
