// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace swiftgs::cli {

/// Where the results of a command go, as `--json` names it: a file; standard output for `-`; nowhere where
/// the name is empty. Of `-`, what the command prints goes to standard error as long as the object lives, so
/// that nothing is mixed with the results. Of several processes the first alone writes.
class ResultFile {
 public:
  /// What the file held stays until the first `write`. Throws `FileError` where the file cannot be
  /// written: an hour of results must find a place to go to.
  explicit ResultFile(const std::string& name);
  ~ResultFile();
  ResultFile(const ResultFile&) = delete;
  ResultFile& operator=(const ResultFile&) = delete;

  bool is_wanted() const { return !name_.empty(); }
  bool is_standard_output() const { return name_ == "-"; }

  /// Replaces what was written before. Standard output gets the last text, when `finish` is called. Throws
  /// `FileError`.
  void write(std::string_view text);

  /// Ends the results. Throws `FileError`.
  void finish();

 private:
  std::string name_, text_;
  int output_ = -1;  ///< standard output, while it is kept for the results
};

}  // namespace swiftgs::cli
