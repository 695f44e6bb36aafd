// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "files.hpp"

namespace swiftgs::test {

/// A compressed PLY in parts, of one chunk and one Gaussian unless said otherwise.
struct CompressedPly {
  std::string format = "binary_little_endian", before{};
  std::vector<std::string> ranges = {
      "min_x",       "min_y",       "min_z",       "max_x",       "max_y",       "max_z",
      "min_scale_x", "min_scale_y", "min_scale_z", "max_scale_x", "max_scale_y", "max_scale_z",
      "min_r",       "min_g",       "min_b",       "max_r",       "max_g",       "max_b"};
  std::vector<float> chunks = {0,  0,  0,  2047, 1023, -2047, -1,   -2,   -3,
                               -1, -2, -3, 0.5f, 0.5f, 0,     0.5f, 0.5f, 1};
  std::vector<std::string> words = {"packed_position", "packed_rotation", "packed_scale", "packed_color"};
  std::vector<std::uint32_t> vertices = {7u << 21 | 8u << 11 | 9u, 512u << 20 | 512u << 10 | 512u, 0,
                                         0x000000ffu};
  int harmonics = 0;
  std::string sh{};  ///< a byte a coefficient

  /// Number of Gaussians, all as the first.
  CompressedPly& repeat(std::size_t count) {
    const auto first = std::vector(vertices.begin(), vertices.begin() + 4);
    vertices.clear();
    for (std::size_t i = 0; i < count; ++i) vertices.insert(vertices.end(), first.begin(), first.end());
    return *this;
  }

  std::string text() const {
    std::string file = "ply\nformat " + format + " 1.0\n" + before;
    const auto element = [&](const char* name, std::size_t rows) {
      file += "element " + std::string(name) + " " + std::to_string(rows) + "\n";
    };
    element("chunk", chunks.size() / ranges.size());
    for (const auto& name : ranges) file += "property float " + name + "\n";
    element("vertex", vertices.size() / 4);
    for (const auto& name : words) file += "property uint " + name + "\n";
    if (harmonics > 0) element("sh", sh.size() / std::size_t(harmonics));
    for (int i = 0; i < harmonics; ++i) file += "property uchar f_rest_" + std::to_string(i) + "\n";
    file += "end_header\n";
    for (const float value : chunks) append(file, value);
    for (const std::uint32_t word : vertices) append(file, word);
    return file + sh;
  }
};

}  // namespace swiftgs::test
