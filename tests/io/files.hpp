// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/error.hpp>

#include "support/files.hpp"

namespace swiftgs::test {

using Strings = std::vector<std::string>;

inline std::span<const std::byte> as_bytes(const std::string& text) {
  return {reinterpret_cast<const std::byte*>(text.data()), text.size()};
}

/// Appends the bytes of `value` as this machine holds them.
template <class T>
void append(std::string& to, T value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  to.append(raw, sizeof(T));
}

/// Puts the bytes of `value` at `offset`.
template <class T>
void set(std::string& content, std::size_t offset, T value) {
  REQUIRE(offset + sizeof(T) <= content.size());
  std::memcpy(content.data() + offset, &value, sizeof(T));
}

/// `content` with its first `from` replaced.
inline std::string with(std::string content, const std::string& from, const std::string& to) {
  return content.replace(content.find(from), from.size(), to);
}

/// `content` with the bytes of `value` at `offset`.
template <class T>
std::string with(std::string content, std::size_t offset, T value) {
  set(content, offset, value);
  return content;
}

/// What `read` complains of, or "" if it does not.
inline std::string complaint(const std::function<void()>& read) {
  try {
    read();
  } catch (const FormatError& error) {
    return error.what();
  }
  return "";
}

/// Checks that `read` does no worse than complain of a byte that differs by `flip`.
inline void check_every_damage(const std::string& content, char flip,
                               const std::function<void(const std::string&)>& read) {
  for (std::size_t i = 0; i < content.size(); ++i)
    CHECK_NOTHROW(complaint([&] { read(with(content, i, char(content[i] ^ flip))); }));
}

/// Checks that `read` takes `content` and throws `FormatError`, in one line, for each shorter file: of more
/// than 64 bytes for every `step`th, from the longest down.
inline void check_every_truncation(const std::string& content,
                                   const std::function<void(const std::string&)>& read,
                                   std::size_t step = 1) {
  CHECK_NOTHROW(read(content));
  for (std::size_t left = content.size(); left > 0; left -= left <= 64 ? 1 : std::min(step, left - 64)) {
    const std::size_t length = left - 1;
    const std::string message = complaint([&] { read(content.substr(0, length)); });
    CHECK_MESSAGE(contains(message, "expected"),
                  "of " << content.size() << " bytes only the first " << length);
    CHECK(!contains(message, "\n"));
  }
}

}  // namespace swiftgs::test
