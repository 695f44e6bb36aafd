// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include <swiftgs/io/replace_file.hpp>

namespace swiftgs::cli {

/// The file of `--json`, or none where the name is empty. What it held stays until the first `write`.
class ResultFile {
 public:
  /// Throws `std::system_error` where the file cannot be written: an hour of results must find a place to go
  /// to.
  explicit ResultFile(const std::string& name) : name_(name) {
    if (!name_.empty()) require_replaceable(name_);
  }

  /// Replaces what was written before. Throws `std::system_error`.
  void write(std::string_view text) {
    if (!name_.empty()) replace_file(name_, text);
  }

 private:
  std::string name_;
};

}  // namespace swiftgs::cli
