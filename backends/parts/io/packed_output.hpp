// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "output_file.hpp"

namespace swiftgs::io {

/// Writes one gzip stream, which is deflated in blocks by as many threads as there are cores. The bytes do
/// not depend on how many.
class GzipWriter {
 public:
  explicit GzipWriter(OutputFile& file);

  void add(std::span<const std::byte> bytes);

  /// Must be called last.
  void finish();

 private:
  void flush(bool last);

  OutputFile& file_;
  std::vector<std::byte> pending_{};  ///< `history_` bytes that are written, and those that are not
  std::size_t history_ = 0;
  std::uint32_t checksum_ = 0;
  std::uint32_t size_ = 0;  ///< modulo 2^32, as gzip states it
};

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
