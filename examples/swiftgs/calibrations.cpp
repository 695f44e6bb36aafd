// SPDX-License-Identifier: Apache-2.0
#include "calibrations.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <system_error>
#include <utility>

#include <swiftgs/sort/adaptive.hpp>

#include "number_text.hpp"
#include "renderer_words.hpp"
#include "scene_input.hpp"
#include "shell_word.hpp"

namespace swiftgs::cli {
namespace {

/// What calibrates the images that `view` asks for, without the renderers.
std::string command_for(const SceneOptions& scene, const ViewOptions& view, const std::string& out) {
  const SceneOptions usual_scene;
  const ViewOptions usual;
  std::string command = "swiftgs calibrate " + shell_word(scene.scene);
  if (scene.spz_frame != usual_scene.spz_frame) command += " --spz-frame " + shell_word(scene.spz_frame);
  if (!view.cameras.empty()) command += " --cameras " + shell_word(view.cameras);
  if (view.scale != usual.scale) command += " --scale " + text_of_number(view.scale);
  if (view.conventions != usual.conventions) command += " --conventions " + shell_word(view.conventions);
  if (!out.empty()) command += " --out " + shell_word(out);
  return command;
}

/// Whether there is a file, or something that its reader can complain of.
bool is_there(const std::filesystem::path& file) {
  std::error_code unreadable;
  return std::filesystem::exists(file, unreadable) || unreadable;
}

}  // namespace

std::vector<std::filesystem::path> calibration_files(const SceneOptions& scene, const std::string& given) {
  if (!given.empty()) return {given};
  if (builtin_size(scene.scene)) return {};
  return sort_calibrations_places(capture_of(scene).scene);
}

std::string calibration_file(const SceneOptions& scene, const std::string& given) {
  const std::vector<std::filesystem::path> files = calibration_files(scene, given);
  return files.empty() ? "" : files.front().string();
}

std::string adaptive_renderers(std::string_view name) {
  const RendererWords words(name);
  return words.backend + "/" + std::string(AdaptiveSort::name) + "/*/" + words.bounds;
}

SortCalibrationKey calibration_key(const AnyRenderer& renderer, const std::string& scene_checksum) {
  const RendererWords words(renderer.name());
  return {.scene = scene_checksum,
          .device = renderer.device_name(),
          .backend = words.backend,
          .bounds = words.bounds};
}

Calibrations::Calibrations(const SceneOptions& scene, const ViewOptions& view,
                           std::shared_ptr<const Scene> content, const std::string& file)
    : files_(calibration_files(scene, file)),
      command_(command_for(scene, view, file)),
      given_(!file.empty()),
      content_(std::move(content)) {}

bool Calibrations::hand_to(AnyRenderer& renderer, const std::vector<View>& views) {
  if (RendererWords(renderer.name()).sort != AdaptiveSort::name) return false;
  const auto file = std::find_if(files_.begin(), files_.end(), is_there);
  if (file == files_.end()) {
    if (given_) say(files_.front().string() + " is not there", renderer);
    return false;
  }
  if (checksum_.empty()) checksum_ = scene_checksum(*content_);
  FoundSortCalibrations found = find_sort_calibrations(files_, calibration_key(renderer, checksum_));
  if (!found.why_none.empty()) return say(found.why_none, renderer), false;
  bool all = true;
  for (const View& view : views) {
    const auto of_its_size = [&](const SortCalibration& calibration) {
      return calibration.width == view.camera.width && calibration.height == view.camera.height;
    };
    if (std::any_of(found.calibrations.begin(), found.calibrations.end(), of_its_size)) continue;
    all = false;
    say(file->string() + " holds no calibration at " + std::to_string(view.camera.width) + "x" +
            std::to_string(view.camera.height),
        renderer);
  }
  renderer.use_calibrations(std::move(found.calibrations));
  return all;
}

void Calibrations::say(const std::string& why, const AnyRenderer& renderer) {
  if (!said_.insert(why).second) return;
  std::fprintf(stderr, "swiftgs: %s; the sort is measured while rendering; run: %s --renderers %s\n",
               why.c_str(), command_.c_str(), shell_word(adaptive_renderers(renderer.name())).c_str());
}

}  // namespace swiftgs::cli
