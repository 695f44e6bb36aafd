// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <swiftgs/statistics.hpp>

namespace swiftgs::cli {

/// How two images differ. JSON has no infinity: `psnr_db` of equal images is written as null.
struct Comparison {
  double psnr_db = 0, ssim = 0, max_abs = 0;
};

/// One frame of `check`, against the reference.
struct CheckResult {
  std::string renderer, scene, view;
  int width = 0, height = 0;
  StageTimes ms;
  double psnr_db = 0, max_abs = 0;
  std::optional<double> photo_psnr_db;  ///< against the photograph, where there is one
};

std::string to_json(const Comparison& comparison);

/// An array, one object a line. `photo_psnr_db` is a member of every object if `with_photos`, null where
/// there is no photograph.
std::string to_json(const std::vector<CheckResult>& results, bool with_photos);

}  // namespace swiftgs::cli
