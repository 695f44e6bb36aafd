// SPDX-License-Identifier: Apache-2.0
#include "result_file.hpp"

#include <cerrno>
#include <cstdio>
#include <system_error>

#include <unistd.h>

#include <swiftgs/io/replace_file.hpp>

#include "draw/team.hpp"

namespace swiftgs::cli {
namespace {

[[noreturn]] void fail() { throw std::system_error(errno, std::generic_category(), "standard output"); }

}  // namespace

ResultFile::ResultFile(const std::string& name) : name_(name) {
  if (!Team::here().leads()) return;
  if (is_standard_output()) {
    std::fflush(stdout);
    output_ = ::dup(STDOUT_FILENO);
    if (output_ < 0 || ::dup2(STDERR_FILENO, STDOUT_FILENO) < 0) fail();
  } else if (is_wanted()) {
    require_replaceable(name_);
  }
}

ResultFile::~ResultFile() {
  if (output_ < 0) return;
  std::fflush(stdout);
  ::dup2(output_, STDOUT_FILENO);
  ::close(output_);
}

void ResultFile::write(std::string_view text) {
  if (!Team::here().leads()) return;
  if (is_standard_output())
    text_ = text;
  else if (is_wanted())
    replace_file(name_, text);
}

void ResultFile::finish() {
  for (std::string_view left = text_; !left.empty();) {
    const ssize_t written = ::write(output_, left.data(), left.size());
    if (written < 0 && errno != EINTR) fail();
    if (written > 0) left.remove_prefix(std::size_t(written));
  }
  text_.clear();
}

}  // namespace swiftgs::cli
