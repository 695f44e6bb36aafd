// SPDX-License-Identifier: Apache-2.0
#include "output_file.hpp"

#include <cerrno>
#include <system_error>
#include <utility>

#include <swiftgs/error.hpp>

namespace swiftgs::io {

OutputFile::OutputFile(const std::filesystem::path& path)
    : path_(path), unfinished_(path), file_(unfinished_.open()) {
  if (!file_) fail();
}

OutputFile::~OutputFile() {
  if (file_) std::fclose(file_);
}

void OutputFile::write(const void* data, std::size_t size) {
  if (std::fwrite(data, 1, size, file_) != size) fail();
  size_ += size;
}

void OutputFile::close() {
  if (std::fclose(std::exchange(file_, nullptr)) != 0) fail();
  try {
    unfinished_.finish();
  } catch (const std::system_error& error) {
    throw FileError(error.code(), path_.string());
  }
}

void OutputFile::fail() const { throw FileError({errno, std::generic_category()}, path_.string()); }

}  // namespace swiftgs::io
