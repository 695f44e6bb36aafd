// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/io/image.hpp>

#include "measure/prune_result.hpp"
#include "progress.hpp"
#include "read/views.hpp"

namespace swiftgs::cli {

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
