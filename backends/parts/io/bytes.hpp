// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include <swiftgs/error.hpp>

namespace swiftgs::io {

/// Bytes of a file and the name that errors call it by.
struct Source {
  std::span<const std::byte> bytes;
  std::string name;
  std::filesystem::path folder{};  ///< of other files that this one names; empty if it was given from memory
  bool mapped = false;             ///< `bytes` are a `MappedFile`'s

  std::string_view text() const { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

  [[noreturn]] void fail(std::uint64_t offset, const std::string& expected) const {
    throw FormatError(name, offset, expected);
  }
};

/// A number stored with the given byte order, at any alignment.
template <class T>
T load(const std::byte* at, std::endian order = std::endian::little) {
  std::array<std::byte, sizeof(T)> raw;
  std::memcpy(raw.data(), at, sizeof(T));
  if (order != std::endian::native) std::reverse(raw.begin(), raw.end());
  return std::bit_cast<T>(raw);
}

/// Stores a number in little-endian byte order, at any alignment.
template <class T>
void store(std::byte* at, T value) {
  auto raw = std::bit_cast<std::array<std::byte, sizeof(T)>>(value);
  if constexpr (std::endian::native != std::endian::little) std::reverse(raw.begin(), raw.end());
  std::memcpy(at, raw.data(), sizeof(T));
}

/// Reads little-endian values front to back; every read is checked against the end.
class ByteReader {
 public:
  explicit ByteReader(const Source& source, std::uint64_t position = 0)
      : source_(source), position_(position) {}

  std::uint64_t position() const { return position_; }
  std::uint64_t remaining() const { return source_.bytes.size() - position_; }
  [[noreturn]] void fail(const std::string& expected) const { source_.fail(position_, expected); }

  /// Throws unless `count` items of at least `size` bytes can follow. Asked before memory is taken for them.
  void expect(std::uint64_t count, std::uint64_t size, const char* what) const {
    if (count > remaining() / size)
      fail("room for " + std::to_string(count) + " " + what + " of at least " + std::to_string(size) +
           " bytes, found " + std::to_string(remaining()) + " bytes");
  }

  /// The next `size` bytes, which `what` names in the error if they are not there.
  const std::byte* take(std::uint64_t size, const char* what) {
    if (size > remaining())
      fail(std::to_string(size) + " bytes for " + what + ", found " + std::to_string(remaining()));
    const std::byte* at = source_.bytes.data() + position_;
    position_ += size;
    return at;
  }

  template <class T>
  T read(const char* what) {
    return load<T>(take(sizeof(T), what));
  }

  /// Characters up to a NUL, which is read too.
  std::string_view c_string(const char* what) {
    const std::string_view rest = source_.text().substr(position_);
    const std::size_t length = rest.find('\0');
    if (length == std::string_view::npos) fail(std::string("a NUL after ") + what);
    position_ += length + 1;
    return rest.substr(0, length);
  }

  void expect_end(const std::string& after) const {
    if (remaining() != 0)
      fail("the end of the file after " + after + ", found " + std::to_string(remaining()) + " more bytes");
  }

 private:
  const Source& source_;
  std::uint64_t position_;
};

}  // namespace swiftgs::io
