// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/io/cameras.hpp>
#include <swiftgs/io/capture.hpp>
#include <swiftgs/io/scene_file.hpp>

#include "support/skip.hpp"

namespace swiftgs::test {

/// A trained scene with the cameras of its photographs, in the order of the images' names.
struct TrainedCapture {
  std::filesystem::path photos;
  std::shared_ptr<const Scene> scene;
  std::vector<Camera> cameras;
};

/// The folder of the capture `name`, in which `part` is; or an empty path, and the running test skipped,
/// where it is not at hand.
inline std::filesystem::path capture_or_skip(const std::string& name, const std::string& part = "") {
#ifdef SWIFTGS_SCENES_DIR
  const std::filesystem::path folder = std::filesystem::path(SWIFTGS_SCENES_DIR) / name;
  if (std::filesystem::exists(folder / part)) return folder;
  skip("no real scene " + (folder.filename() / part).string());
#else
  skip("no folder of real scenes for " + (name + "/" + part));
#endif
  return {};
}

inline TrainedCapture read_capture(const std::filesystem::path& folder) {
  const Capture found = find_capture(folder);
  return {found.photos, std::make_shared<const Scene>(load_scene(found.scene)), load_cameras(found.cameras)};
}

/// Whether `name`, a renderer's, holds `word`.
inline bool has(std::string_view name, std::string_view word) {
  return name.find(word) != std::string_view::npos;
}

}  // namespace swiftgs::test
