// SPDX-License-Identifier: Apache-2.0

#include "output_file.hpp"

#include <cerrno>
#include <random>
#include <string>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <swiftgs/error.hpp>
#include <swiftgs/io/replace_file.hpp>

namespace swiftgs::io {
namespace {

namespace fs = std::filesystem;

/// A name in the same folder that no other has.
fs::path beside(const fs::path& path) {
  std::random_device random;
  fs::path name = path;
  name += std::string(".").append(std::to_string(random())).append(std::to_string(random())).append(".new");
  return name;
}

[[noreturn]] void fail_to_link(const fs::path& path) {
  throw fs::filesystem_error("linkat", path, std::error_code(errno, std::generic_category()));
}

/// Where /proc shows an open file.
std::string name_of(int descriptor) { return "/proc/self/fd/" + std::to_string(descriptor); }

}  // namespace

fs::path target_of(const fs::path& path) {
  constexpr int most_links = 40;  // as Linux follows them
  fs::path target = path;
  std::error_code none;
  for (int links = 0; links < most_links; ++links) {
    const fs::path next = fs::read_symlink(target, none);
    if (none) return target;
    target = target.parent_path() / next;  // `next` alone where it is absolute
  }
  throw FileError({ELOOP, std::generic_category()}, path.string());
}

void put_in_place(const fs::path& from, const fs::path& to) {
  std::error_code none;
  const fs::file_status before = fs::status(to, none);
  if (fs::exists(before)) fs::permissions(from, before.permissions());
  fs::rename(from, to);
}

fs::perms new_permissions(const fs::path& path) {
  UnfinishedFile file(path);
  std::FILE* const made = file.open();
  struct stat status;
  if (!made || ::fstat(::fileno(made), &status) != 0)
    throw fs::filesystem_error("open", path, std::error_code(errno, std::generic_category()));
  std::fclose(made);
  return fs::perms(status.st_mode) & fs::perms::mask;
}

bool is_stream(const fs::path& path) {
  struct stat file, output;
  if (::stat(path.c_str(), &file) != 0) return false;
  if (!S_ISREG(file.st_mode)) return true;
  // /dev/stdout, where a shell leads it to a file: the shell's descriptor would stay with the old one.
  return ::fstat(STDOUT_FILENO, &output) == 0 && file.st_dev == output.st_dev && file.st_ino == output.st_ino;
}

UnfinishedFile::UnfinishedFile(const fs::path& path) {
  if (is_stream(path)) {
    path_ = path;
  } else {
    place_ = target_of(path);
    path_ = beside(place_);
  }
}

std::FILE* UnfinishedFile::open() {
#if defined(O_TMPFILE)
  if (!place_.empty()) {
    const fs::path folder = place_.has_parent_path() ? place_.parent_path() : ".";
    const int descriptor = ::open(folder.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666);
    // It gets its name by way of /proc.
    if (descriptor >= 0 && ::access(name_of(descriptor).c_str(), F_OK) == 0) {
      unnamed_ = ::fcntl(descriptor, F_DUPFD_CLOEXEC, 0);
      if (unnamed_ >= 0)
        if (std::FILE* file = ::fdopen(descriptor, "wb")) return file;
    }
    if (descriptor >= 0) ::close(descriptor);
    forget_unnamed();
  }
#endif
  return std::fopen(path_.c_str(), "wb");
}

bool UnfinishedFile::give_name(const fs::path& name) const {
  if (::linkat(AT_FDCWD, name_of(unnamed_).c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW) == 0)
    return true;
  if (errno != EEXIST) fail_to_link(place_);
  return false;
}

void UnfinishedFile::forget_unnamed() {
  if (unnamed_ >= 0) ::close(unnamed_);
  unnamed_ = -1;
}

UnfinishedFile::~UnfinishedFile() {
  forget_unnamed();
  std::error_code gone;
  if (!place_.empty()) fs::remove(path_, gone);
}

void UnfinishedFile::finish() {
  if (place_.empty()) return;
  if (unnamed_ >= 0) {
    const bool placed = give_name(place_);  // where nothing is to be replaced, no other name is needed
    if (!placed && !give_name(path_)) fail_to_link(place_);
    forget_unnamed();
    if (placed) {
      place_.clear();
      return;
    }
  }
  put_in_place(path_, place_);
  place_.clear();
}

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

namespace swiftgs {

void replace_file(const std::filesystem::path& path,
                  const std::function<void(const std::filesystem::path&)>& write) {
  // Failures are those of `path`, whatever name was written to.
  try {
    io::UnfinishedFile file(path);
    write(file.path());
    file.finish();
  } catch (const std::system_error& error) {
    throw FileError(error.code(), path.string());
  }
}

void replace_file(const std::filesystem::path& path, std::string_view content) {
  io::OutputFile file(path);
  file.write(content.data(), content.size());
  file.close();
}

void require_replaceable(const std::filesystem::path& path) {
  std::error_code none;
  if (std::filesystem::is_directory(path, none))
    throw FileError({EISDIR, std::generic_category()}, path.string());
  if (!io::is_stream(path)) io::OutputFile{path};  // gone again, as it is never closed
}

}  // namespace swiftgs
