// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>

#include "unfinished_file.hpp"

namespace swiftgs::io {

/// Writes a file front to back. The file gets its name when it is closed, so nobody finds a part of it. Every
/// failure throws `FileError` with the path and the reason.
class OutputFile {
 public:
  explicit OutputFile(const std::filesystem::path& path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void write(const void* data, std::size_t size);

  std::uint64_t size() const { return size_; }  ///< bytes written so far

  /// Must be called last: a full disk may show only here.
  void close();

 private:
  [[noreturn]] void fail() const;

  std::filesystem::path path_;
  UnfinishedFile unfinished_;
  std::FILE* file_ = nullptr;
  std::uint64_t size_ = 0;
};

}  // namespace swiftgs::io
