// SPDX-License-Identifier: Apache-2.0
#include "draw/npy.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>
#include <string_view>
#include <system_error>

#include <swiftgs/error.hpp>
#include <swiftgs/io/replace_file.hpp>

#include "words.hpp"

namespace swiftgs::cli {
namespace {

constexpr std::string_view magic("\x93NUMPY\x01\x00", 8);  // version 1.0: the header's length has two bytes

template <class T>
std::vector<double> values_in(std::string_view bytes) {
  std::vector<double> values;
  for (T value{}; bytes.size() >= sizeof value; bytes.remove_prefix(sizeof value)) {
    std::memcpy(&value, bytes.data(), sizeof value);
    values.push_back(double(value));
  }
  return values;
}

/// The numbers in the brackets behind `'shape':`; empty where one is none.
std::vector<std::size_t> shape_in(std::string_view header) {
  std::vector<std::size_t> shape;
  const std::size_t open = header.find('(', header.find("'shape'")), close = header.find(')', open);
  if (close == header.npos) return {};
  for (std::string_view word : split(header.substr(open + 1, close - open - 1), ',')) {
    word.remove_prefix(std::min(word.find_first_not_of(' '), word.size()));
    if (word.empty()) continue;
    const auto side = parse<std::uint32_t>(word);
    if (!side) return {};
    shape.push_back(*side);
  }
  return shape;
}

}  // namespace

Array read_npy(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw FileError({errno, std::generic_category()}, file.string());
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  constexpr std::size_t begin = magic.size() + 2;
  if (!bytes.starts_with(magic) || bytes.size() < begin)
    throw FormatError(file.string(), 0, "an array of NumPy, version 1.0");
  const std::size_t length =
      std::uint8_t(bytes[begin - 2]) + 256 * std::size_t(std::uint8_t(bytes[begin - 1]));
  const std::string_view header = std::string_view(bytes).substr(begin, length);
  const std::string_view data = std::string_view(bytes).substr(std::min(begin + length, bytes.size()));
  const bool is_float = header.find("'<f4'") != header.npos;
  if ((!is_float && header.find("'<f8'") == header.npos) || header.find("True") != header.npos)
    throw FormatError(file.string(), begin, "floats of 4 or 8 bytes, little-endian and in C order");
  Array array{.shape = shape_in(header),
              .values = is_float ? values_in<float>(data) : values_in<double>(data),
              .epsilon = is_float ? double(std::numeric_limits<float>::epsilon())
                                  : std::numeric_limits<double>::epsilon()};
  std::size_t count = 1;
  for (const std::size_t side : array.shape) count *= side;
  if (array.shape.empty() || count != array.values.size())
    throw FormatError(file.string(), begin + length, "as many values as the shape says");
  return array;
}

void write_npy(const std::filesystem::path& file, const std::vector<std::size_t>& shape,
               const std::vector<double>& values) {
  std::string header = "{'descr': '<f8', 'fortran_order': False, 'shape': (";
  for (const std::size_t side : shape) header += std::to_string(side) + ", ";
  header += "), }";
  const std::size_t before = magic.size() + 2;
  header.append(63 - (before + header.size()) % 64, ' ').append("\n");  // data begin at a multiple of 64
  std::string bytes(magic);
  bytes.append({char(header.size() % 256), char(header.size() / 256)}).append(header);
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(double));
  replace_file(file, bytes);
}

}  // namespace swiftgs::cli
