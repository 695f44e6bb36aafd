// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/io/sort_calibrations.hpp>
#include <swiftgs/scene.hpp>

#include "options.hpp"
#include "views.hpp"

namespace swiftgs::cli {

/// The files of measurements of a scene, in the order in which they count: `given` alone, or those of
/// `sort_calibrations_places` where that is empty. None for the built-in scene unless given.
std::vector<std::filesystem::path> calibration_files(const SceneOptions& scene, const std::string& given);

/// The first of them, or an empty name.
std::string calibration_file(const SceneOptions& scene, const std::string& given);

/// A pattern for renderers with the sort 'adaptive' that share measurements with the one called `name`: the
/// same backend and bounds, and any rasterizer, which has no part in the sort.
std::string adaptive_renderers(std::string_view name);

/// What measurements with `renderer` hold for.
SortCalibrationKey calibration_key(const AnyRenderer& renderer, const std::string& scene_checksum);

/// What `calibrate` has measured of a scene, for renderers whose sort is `adaptive`.
class Calibrations {
 public:
  /// Of `content`, which `scene` names. `file` is as for `calibration_files`; `view` is what is rendered.
  Calibrations(const SceneOptions& scene, const ViewOptions& view, std::shared_ptr<const Scene> content,
               const std::string& file);

  /// Hands to `renderer` what holds for it. Where there is a file with nothing for `renderer` or for the size
  /// of one of `views`, a line on standard error says why and what to run, once for each reason; the
  /// renderer then measures while it renders. Other sorts than `adaptive` have no use for it.
  /// Returns whether what it handed over holds for all of `views`, so that nothing is left to measure.
  bool hand_to(AnyRenderer& renderer, const std::vector<View>& views);

 private:
  void say(const std::string& why, const AnyRenderer& renderer);

  std::vector<std::filesystem::path> files_;
  std::string command_;
  bool given_;
  std::shared_ptr<const Scene> content_;
  std::string checksum_;  ///< empty until it is asked for
  std::set<std::string> said_;
};

}  // namespace swiftgs::cli
