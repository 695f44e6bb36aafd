// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <swiftgs/any_renderer.hpp>

#include "options.hpp"
#include "result_file.hpp"
#include "result_head.hpp"
#include "views.hpp"

namespace swiftgs::cli {

/// Renderers that differ in the sort alone.
struct SortTrio {
  AnyRenderer* standard;
  AnyRenderer* early;
  AnyRenderer* adaptive;  ///< which has been handed what was measured
};

/// What the choice of a sort is worth, against both strategies on every view.
class CalibrationCheck {
 public:
  /// Rows go to `json`, a file that docs/results.md describes, unless that is empty. `notes` are
  /// `ResultHead::notes`.
  CalibrationCheck(const std::string& json, const SceneOptions& scene, std::vector<std::string> notes);

  /// Times all three on `views`, at least one, of one size; prints means and regret, and adds a row to the
  /// file.
  void run(const SortTrio& sorts, const std::vector<View>& views, const RenderSettings& settings,
           std::size_t gaussians);

  /// Ends the file.
  void finish() { file_.finish(); }

 private:
  ResultFile file_;
  ResultHead head_;
  std::string scene_;
  std::vector<std::string> rows_;
};

}  // namespace swiftgs::cli
