// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "result_head.hpp"

namespace swiftgs::cli {

/// A scene over the views that were held out; means over these.
struct PruneSide {
  std::size_t gaussians = 0;
  std::optional<double> ms;             ///< of a frame
  std::optional<double> photo_psnr_db;  ///< against the photographs
  std::optional<double> photo_ssim;
  std::optional<double> unpruned_psnr_db;  ///< against the frames of the scene before
};

/// What `prune` did, as docs/schemas/prune.schema.json describes it.
struct PruneResult {
  ResultHead head{};
  std::string scene, score, backend, conventions;
  double keep = 1;
  std::size_t views = 0, held_out = 0;  ///< that were scored, and that were rendered before and after
  double kept_weight = 1;               ///< share of all scores
  PruneSide before{}, after{};
};

/// One object, with a line break at its end.
std::string to_json(const PruneResult& result);

/// Prints the two sides as a table with the columns that there are numbers for.
void print_table(const PruneResult& result);

}  // namespace swiftgs::cli
