// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include <swiftgs/error.hpp>

namespace swiftgs::io {

/// f(), which looks at folders: what `std::filesystem` throws becomes a `FileError`.
template <class F>
auto with_file_errors(const F& f) {
  try {
    return f();
  } catch (const std::filesystem::filesystem_error& error) {
    throw FileError(error.code(), error.path1().string());
  }
}

}  // namespace swiftgs::io
