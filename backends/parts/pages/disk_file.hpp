// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

namespace swiftgs::pages {

/// A file that is read and written anywhere. All functions throw `FileError` with the path and the reason.
class DiskFile {
 public:
  /// Opens a file, which it makes if there is none.
  explicit DiskFile(const std::filesystem::path& path);
  /// A file without a name in a folder, so that nothing of it stays behind a program that is killed.
  static DiskFile unnamed_in(const std::filesystem::path& folder);
  ~DiskFile();
  DiskFile(DiskFile&& other) noexcept;
  DiskFile& operator=(DiskFile&&) = delete;

  /// Throws `InvalidArgument` where another `DiskFile` has locked it, or has removed it.
  void lock();
  std::uint64_t size() const;
  void resize(std::uint64_t size);
  /// The file has these bytes.
  void read(std::uint64_t offset, std::span<std::byte> to) const;
  void write(std::uint64_t offset, std::span<const std::byte> bytes);
  /// Must be called last: a full disk may show only here.
  void close();

  const std::filesystem::path& path() const { return path_; }

 private:
  DiskFile(std::filesystem::path path, int descriptor);
  [[noreturn]] void fail() const;

  std::filesystem::path path_;
  int descriptor_;
};

}  // namespace swiftgs::pages
