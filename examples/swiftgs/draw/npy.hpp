// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

namespace swiftgs::cli {

/// An array of NumPy, in C order.
struct Array {
  std::vector<std::size_t> shape;
  std::vector<double> values;
  double epsilon = 0;  ///< distance from 1 to the next number of the file's kind
};

/// Reads a .npy of floats of 4 or 8 bytes. Throws `FormatError`, or `FileError` if it cannot be read.
Array read_npy(const std::filesystem::path& file);

/// Writes a .npy of doubles. Throws `FileError`.
void write_npy(const std::filesystem::path& file, const std::vector<std::size_t>& shape,
               const std::vector<double>& values);

}  // namespace swiftgs::cli
