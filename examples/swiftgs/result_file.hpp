// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cerrno>
#include <fstream>
#include <string>
#include <system_error>

namespace swiftgs::cli {

/// The file of `--json`, or none. Opened before anything is rendered: an hour of results must find a place to
/// go to. Throws `std::system_error` where it cannot be written.
class ResultFile {
 public:
  explicit ResultFile(const std::string& name) : name_(name) { write(""); }

  /// Replaces what was written before.
  void write(const std::string& text) {
    if (name_.empty()) return;
    errno = 0;
    std::ofstream out(name_, std::ios::binary);
    out << text << std::flush;
    if (!out) throw std::system_error(errno ? errno : EIO, std::generic_category(), name_);
  }

 private:
  std::string name_;
};

}  // namespace swiftgs::cli
