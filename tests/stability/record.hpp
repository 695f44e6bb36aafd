// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The recorded errors of stages, of which docs/conventions.md shows a table.

#include <algorithm>
#include <fstream>
#include <stdexcept>
#include <string>

#include <nlohmann/json.hpp>

#include "stability/ulps.hpp"

namespace swiftgs::test {

/// Rows of `ulps.json`, as `ulps_table --json` prints them.
class Record {
 public:
  explicit Record(const std::string& path) {
    std::ifstream file(path);
    if (!file) throw std::runtime_error(path + ": cannot be read; expected what ulps_table --json prints");
    json_ = nlohmann::json::parse(file);
  }

  /// What `found` was when it was recorded, or the largest of all targets where its target was not; negative
  /// where the stage is not recorded.
  double ulps(const Worst& found) const {
    double exact = -1, largest = -1;
    for (const auto& row : json_.at("rows")) {
      if (row.at("stage").get<std::string>() != found.stage) continue;
      const double ulps = row.at("ulps").get<double>();
      largest = std::max(largest, ulps);
      if (row.at("target").get<std::string>() == found.target) exact = ulps;
    }
    return exact >= 0 ? exact : largest;
  }
  std::size_t size() const { return json_.at("rows").size(); }

 private:
  nlohmann::json json_;
};

}  // namespace swiftgs::test
