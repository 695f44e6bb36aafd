// SPDX-License-Identifier: Apache-2.0
#include "calibration_store.hpp"

#include <cstdio>
#include <exception>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace swiftgs::cli {

CalibrationStore::CalibrationStore(std::vector<std::filesystem::path> files) : files_(std::move(files)) {
  if (!open()) throw std::runtime_error(why_not_ + (files_.size() > 1 ? "; expected --out" : ""));
}

/// Goes on to the first file from `at_` on that can be written.
bool CalibrationStore::open() {
  for (; at_ < files_.size(); ++at_) {
    try {
      std::error_code failed;  // which writing will tell
      if (at_ > 0) std::filesystem::create_directories(files_[at_].parent_path(), failed);
      in_file_ = add_sort_calibrations(files_[at_], {});
      return true;
    } catch (const std::runtime_error& error) {
      why_not_ += (why_not_.empty() ? "" : "; ") + std::string(error.what());
    }
  }
  return false;
}

void CalibrationStore::add(const SavedSortCalibration& measured) {
  while (at_ < files_.size()) {
    try {
      in_file_ = add_sort_calibrations(files_[at_], {measured}) + 1;
      return;
    } catch (const std::runtime_error& error) {
      why_not_ += (why_not_.empty() ? "" : "; ") + std::string(error.what());
      ++at_;
      const std::string next = open() ? "kept in " + files_[at_].string() : "not kept";
      std::fprintf(stderr, "swiftgs: %s; the calibration is %s\n", error.what(), next.c_str());
    }
  }
}

std::string CalibrationStore::summary() const {
  if (at_ == files_.size()) return "not all calibrations were kept: " + why_not_;
  std::string line = files_[at_].string() + ": " + std::to_string(in_file_) +
                     (in_file_ == 1 ? " calibration" : " calibrations");
  return why_not_.empty() ? line : line + ", as another place cannot be written: " + why_not_;
}

}  // namespace swiftgs::cli
