// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <span>
#include <stdexcept>
#include <string>

#include <doctest/doctest.h>
#include <stdlib.h>

#include <swiftgs/error.hpp>

namespace swiftgs::test {

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

/// A folder of its own that is gone after the test.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "swiftgs_io_XXXXXX").string();
    if (!::mkdtemp(name.data())) throw std::runtime_error("no temporary folder");
    path_ = name;
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

  /// Writes a file, with the folders that lead to it.
  std::filesystem::path write(const std::string& name, const std::string& content) const {
    const std::filesystem::path path = path_ / name;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << content;
    return path;
  }

 private:
  std::filesystem::path path_;
};

inline std::string content_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
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

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// Checks that `read` takes `content` and throws `FormatError`, in one line, for all that a shorter file may
/// hold.
inline void check_every_truncation(const std::string& content,
                                   const std::function<void(const std::string&)>& read) {
  CHECK_NOTHROW(read(content));
  for (std::size_t length = 0; length < content.size(); ++length) {
    const std::string message = complaint([&] { read(content.substr(0, length)); });
    CHECK_MESSAGE(contains(message, "expected"),
                  "of " << content.size() << " bytes only the first " << length);
    CHECK(!contains(message, "\n"));
  }
}

}  // namespace swiftgs::test
