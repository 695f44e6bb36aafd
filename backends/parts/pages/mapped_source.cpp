// SPDX-License-Identifier: Apache-2.0
#include "mapped_source.hpp"

#include <cerrno>
#include <cstring>
#include <memory>
#include <system_error>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <swiftgs/error.hpp>

namespace swiftgs::pages {

MappedSource map_source(const std::filesystem::path& path) {
  const auto fail = [&](int code) { throw FileError({code, std::generic_category()}, path.string()); };
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) fail(errno);
  const std::unique_ptr<const int, void (*)(const int*)> closed(&file,
                                                                [](const int* open) { ::close(*open); });
  struct stat status {};
  if (::fstat(file, &status) != 0) fail(errno);
  if (S_ISDIR(status.st_mode)) fail(EISDIR);
  const auto size = std::size_t(status.st_size);
  if (size == 0) return {[](std::uint64_t, std::span<std::byte>) {}, 0};  // there are no empty mappings
  void* const mapping = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, file, 0);
  if (mapping == MAP_FAILED) fail(errno);
  const std::shared_ptr<const std::byte> bytes(
      static_cast<const std::byte*>(mapping),
      [size](const std::byte* at) { ::munmap(const_cast<std::byte*>(at), size); });
  return {[bytes](std::uint64_t offset, std::span<std::byte> to) {
            std::memcpy(to.data(), bytes.get() + offset, to.size());
          },
          size};
}

}  // namespace swiftgs::pages
