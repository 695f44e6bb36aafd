// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

#include "support/files.hpp"

namespace swiftgs::test {

/// Replaces a number of a binary PLY of floats, which has `rows` rows: no writer writes a NaN.
inline void set_ply_number(const std::filesystem::path& path, std::size_t rows, std::size_t row,
                           std::size_t column, float value) {
  std::string content = content_of(path);
  const std::size_t header = content.find("end_header\n") + 11, row_bytes = (content.size() - header) / rows;
  std::memcpy(content.data() + header + row * row_bytes + column * sizeof value, &value, sizeof value);
  std::ofstream(path, std::ios::binary) << content;
}

}  // namespace swiftgs::test
