// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "output_file.hpp"

namespace swiftgs::io {

/// A ZIP archive of entries that are compressed already, written front to back.
class ZipWriter {
 public:
  explicit ZipWriter(OutputFile& file) : file_(file) {}

  /// Throws `CapacityError` beyond 4 GiB, for which ZIP has another format.
  void add(const std::string& name, const std::string& content);

  /// Must be called last.
  void finish();

 private:
  std::uint32_t offset() const;

  OutputFile& file_;
  std::string directory_{};
  std::uint16_t entries_ = 0;
};

}  // namespace swiftgs::io
