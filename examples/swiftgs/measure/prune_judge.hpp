// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/io/image.hpp>

#include "notes.hpp"
#include "read/views.hpp"
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

/// What a scene is judged by before and after: views that chose nothing of it.
struct HeldOut {
  std::vector<View> views;
  std::vector<std::optional<Image>> photos;  ///< of each view, or empty
  RenderSettings settings;
  std::string renderer;
};

/// Renders the held-out views. Their colours are compared with `unpruned` where that has frames, and become
/// it where it has none.
PruneSide judge(const HeldOut& held_out, const std::shared_ptr<const Scene>& scene,
                std::vector<std::vector<float>>& unpruned, Progress& progress);

}  // namespace swiftgs::cli
