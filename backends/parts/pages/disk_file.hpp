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
  /// Opens and locks a file. Makes it, for this user alone, if there is none; an empty one is temporary.
  /// Throws `InvalidArgument` where another `DiskFile` has locked or removed it, or it is no regular file of
  /// this user with one name.
  explicit DiskFile(const std::filesystem::path& path);
  /// A file without a name in a folder, so that nothing of it stays behind a program that is killed.
  static DiskFile unnamed_in(const std::filesystem::path& folder);
  ~DiskFile();
  DiskFile(DiskFile&& other) noexcept;
  DiskFile& operator=(DiskFile&&) = delete;

  /// Whether the destructor removes the file, before it unlocks it.
  void set_temporary(bool temporary) { is_temporary_ = temporary; }
  bool is_temporary() const { return is_temporary_; }

  std::uint64_t size() const;
  void resize(std::uint64_t size);
  /// Throws if the file ends before `to` is filled.
  void read(std::uint64_t offset, std::span<std::byte> to) const;
  void write(std::uint64_t offset, std::span<const std::byte> bytes);
  /// Must be called last: writes all to the disk, so that a full one shows here at the latest.
  void close();

  const std::filesystem::path& path() const { return path_; }

 private:
  DiskFile(std::filesystem::path path, int descriptor);
  [[noreturn]] void fail() const;
  void lock();

  std::filesystem::path path_;
  int descriptor_;
  bool is_temporary_ = false;
};

/// Writes names that changed in a folder to the disk, where the file system can.
void sync_folder(const std::filesystem::path& folder) noexcept;

}  // namespace swiftgs::pages
