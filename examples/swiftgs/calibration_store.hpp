// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include <swiftgs/io/sort_calibrations.hpp>

namespace swiftgs::cli {

/// Keeps what `calibrate` measures in the first of several files that can be written.
class CalibrationStore {
 public:
  /// `files` are tried in this order; folders that lead to any but the first are made. Throws where none can
  /// be written, before anything is measured.
  explicit CalibrationStore(std::vector<std::filesystem::path> files);

  /// Adds a measurement. A file that can be written no more is said on standard error, and the next takes its
  /// place; what is measured already is worth more than an error.
  void add(const SavedSortCalibration& measured);

  /// One line: where they are and how many, and why not in the first file.
  std::string summary() const;

 private:
  bool open();

  std::vector<std::filesystem::path> files_;
  std::size_t at_ = 0, in_file_ = 0;
  std::string why_not_;  ///< of the files before `at_`
};

}  // namespace swiftgs::cli
