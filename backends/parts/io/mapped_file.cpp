// SPDX-License-Identifier: Apache-2.0
#include "mapped_file.hpp"

#include <cerrno>
#include <string>
#include <system_error>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <swiftgs/error.hpp>

namespace swiftgs::io {
namespace {

/// Of what can be opened and is no file: the system has no word for it.
class NoRegularFile final : public std::error_category {
 public:
  const char* name() const noexcept override { return "swiftgs"; }
  std::string message(int) const override { return "expected a regular file"; }
};

const NoRegularFile no_regular_file;

}  // namespace

MappedFile::MappedFile(const std::filesystem::path& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) throw FileError({errno, std::generic_category()}, path.string());
  const auto fail = [&](int code, const std::error_category& category = std::generic_category()) {
    ::close(file);
    throw FileError({code, category}, path.string());
  };

  struct stat status {};
  if (::fstat(file, &status) != 0) fail(errno);
  if (S_ISDIR(status.st_mode)) fail(EISDIR);
  if (!S_ISREG(status.st_mode)) fail(1, no_regular_file);
  size_ = static_cast<std::size_t>(status.st_size);
  identity_ = {std::uint64_t(status.st_dev), std::uint64_t(status.st_ino)};
  // An empty file is legal to open, and empty mappings do not exist.
  if (size_ > 0) {
    void* mapping = ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, file, 0);
    if (mapping == MAP_FAILED) fail(errno);
    data_ = static_cast<const std::byte*>(mapping);
  }
  ::close(file);
}

MappedFile::~MappedFile() {
  if (data_) ::munmap(const_cast<std::byte*>(data_), size_);
}

void let_go(const Source& source, std::uint64_t begin, std::uint64_t end) {
  if (!source.mapped) return;
  // A mapping begins at a page. Pages that are only partly in the range belong to the neighbours as well.
  const auto page = std::uint64_t(::sysconf(_SC_PAGESIZE));
  const std::uint64_t first = (begin + page - 1) / page * page, last = end / page * page;
  if (first < last)
    ::madvise(const_cast<std::byte*>(source.bytes.data()) + first, last - first, MADV_DONTNEED);
}

}  // namespace swiftgs::io
