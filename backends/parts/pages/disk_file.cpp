// SPDX-License-Identifier: Apache-2.0
#include "disk_file.hpp"

#include <cerrno>
#include <cstdlib>
#include <string>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <swiftgs/error.hpp>

namespace swiftgs::pages {

DiskFile::DiskFile(std::filesystem::path path, int descriptor)
    : path_(std::move(path)), descriptor_(descriptor) {
  if (descriptor_ < 0) fail();
}

DiskFile::DiskFile(const std::filesystem::path& path)
    : DiskFile(path, ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600)) {
  lock();
  is_temporary_ = size() == 0;
}

DiskFile DiskFile::unnamed_in(const std::filesystem::path& folder) {
#if defined(O_TMPFILE)
  const int descriptor = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (descriptor >= 0) return {folder, descriptor};
#endif
  std::string name = (folder / "pages.XXXXXX").string();
  const int named = ::mkostemp(name.data(), O_CLOEXEC);
  if (named >= 0) ::unlink(name.c_str());
  return {folder, named};
}

DiskFile::DiskFile(DiskFile&& other) noexcept
    : path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      is_temporary_(other.is_temporary_) {}

DiskFile::~DiskFile() {
  if (descriptor_ < 0) return;
  if (is_temporary_) ::unlink(path_.c_str());
  ::close(descriptor_);
}

void DiskFile::fail() const {
  throw FileError({errno != 0 ? errno : EIO, std::generic_category()}, path_.string());
}

void DiskFile::lock() {
  const bool taken = ::flock(descriptor_, LOCK_EX | LOCK_NB) != 0;
  if (taken && errno != EWOULDBLOCK) fail();
  struct stat file;
  if (::fstat(descriptor_, &file) != 0) fail();
  if (taken || file.st_nlink == 0)
    detail::refuse(path_.string(), ": another build writes it, expected one at a time");
  if (!S_ISREG(file.st_mode) || file.st_nlink != 1 || file.st_uid != ::geteuid())
    detail::refuse(path_.string(), ": expected none, or a regular file of this user with one name");
}

std::uint64_t DiskFile::size() const {
  struct stat file;
  if (::fstat(descriptor_, &file) != 0) fail();
  return std::uint64_t(file.st_size);
}

void DiskFile::resize(std::uint64_t size) {
  if (::ftruncate(descriptor_, off_t(size)) != 0) fail();
}

void DiskFile::read(std::uint64_t offset, std::span<std::byte> to) const {
  while (!to.empty()) {
    errno = 0;
    const ssize_t got = ::pread(descriptor_, to.data(), to.size(), off_t(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) fail();
    offset += std::uint64_t(got), to = to.subspan(std::size_t(got));
  }
}

void DiskFile::write(std::uint64_t offset, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t put = ::pwrite(descriptor_, bytes.data(), bytes.size(), off_t(offset));
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) fail();
    offset += std::uint64_t(put), bytes = bytes.subspan(std::size_t(put));
  }
}

void DiskFile::close() {
  if (::fdatasync(descriptor_) != 0 || ::close(std::exchange(descriptor_, -1)) != 0) fail();
}

void sync_folder(const std::filesystem::path& folder) noexcept {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  ::fsync(descriptor);
  ::close(descriptor);
}

}  // namespace swiftgs::pages
