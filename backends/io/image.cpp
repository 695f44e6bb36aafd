// SPDX-License-Identifier: Apache-2.0
#include <string>

#include <swiftgs/camera.hpp>
#include <swiftgs/error.hpp>

#include "image_parsing.hpp"
#include "mapped_file.hpp"

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

}  // namespace swiftgs
