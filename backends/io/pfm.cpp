// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <string>

#include "image_parsing.hpp"
#include "output_file.hpp"
#include "tokens.hpp"

namespace swiftgs {
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
