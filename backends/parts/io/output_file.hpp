// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>

#include <swiftgs/frame/api.hpp>

namespace swiftgs::io {

/// A file beside the one that it replaces when it is whole; it is removed unless `finish` is called. What is
/// no regular file, such as a pipe, and standard output are written to as they are. Links stay, and lead to
/// the new file, which has the permissions of the old one if there was one.
class UnfinishedFile {
 public:
  explicit UnfinishedFile(const std::filesystem::path& path);
  ~UnfinishedFile();
  UnfinishedFile(const UnfinishedFile&) = delete;
  UnfinishedFile& operator=(const UnfinishedFile&) = delete;

  /// Where to write.
  const std::filesystem::path& path() const { return path_; }

  /// Opens it for writing, or returns null, as `std::fopen` does. Where the file system can, it then has no
  /// name until `finish`: of a program that is killed nothing stays behind, unless that happens while
  /// `finish` replaces another file. Close the file before `finish`.
  std::FILE* open();

  /// Puts the file in its place. Throws `std::filesystem::filesystem_error`.
  void finish();

 private:
  /// Whether nothing has this name, which the file without one then gets.
  bool give_name(const std::filesystem::path& name) const;
  void forget_unnamed();

  std::filesystem::path place_;  ///< empty once it is filled, and for what is written to as it is
  std::filesystem::path path_;
  int unnamed_ = -1;  ///< descriptor of a file without a name
};

/// What `path` leads to by way of links, whether it is there or not. Throws `FileError` for too many.
SWIFTGS_API std::filesystem::path target_of(const std::filesystem::path& path);

/// Renames `from` to `to`, with the permissions of the file that it replaces, if there is one. Throws
/// `std::filesystem::filesystem_error`.
SWIFTGS_API void put_in_place(const std::filesystem::path& from, const std::filesystem::path& to);

/// Permissions that a file gets where `path` is made. Throws likewise.
SWIFTGS_API std::filesystem::perms new_permissions(const std::filesystem::path& path);

/// Whether `path` is written to as it is.
SWIFTGS_API bool is_stream(const std::filesystem::path& path);

/// Writes a file front to back. It gets its name when it is closed, so nobody finds a part of it. Every
/// failure throws `FileError` with the path and the reason.
class SWIFTGS_API OutputFile {
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
