// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/api.hpp>

#include "bytes.hpp"

namespace swiftgs::io {

/// Tells files apart, whatever names and links lead to them.
struct FileIdentity {
  std::uint64_t device = 0, number = 0;
  auto operator<=>(const FileIdentity&) const = default;
};

/// A regular file, mapped read-only. The kernel may drop its pages at any time, so it takes no memory that
/// the scene needs. Throws `FileError` with the path and the reason.
class SWIFTGS_API MappedFile {
 public:
  explicit MappedFile(const std::filesystem::path& path);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  std::span<const std::byte> bytes() const { return {data_, size_}; }

  /// The same for all names of one file.
  FileIdentity identity() const { return identity_; }

 private:
  const std::byte* data_ = nullptr;
  std::size_t size_ = 0;
  FileIdentity identity_{};
};

/// Takes bytes [begin, end) of a mapped file, which are read for the last time, out of this process's memory.
/// Nothing happens to bytes from elsewhere.
void let_go(const Source& source, std::uint64_t begin, std::uint64_t end);

/// f(), which looks at folders: what `std::filesystem` throws becomes a `FileError`.
template <class F>
auto with_file_errors(const F& f) {
  try {
    return f();
  } catch (const std::filesystem::filesystem_error& error) {
    throw FileError(error.code(), error.path1().string());
  }
}

}  // namespace swiftgs::io
