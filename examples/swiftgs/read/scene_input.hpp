// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <swiftgs/camera.hpp>
#include <swiftgs/io/capture.hpp>
#include <swiftgs/io/scene_file.hpp>

#include "options.hpp"

namespace swiftgs::cli {

/// Gaussians that `scene` asks of the built-in scene, or nothing if it names a file. Throws
/// `InvalidArgument` for `builtin:` with anything but a number.
std::optional<std::size_t> builtin_size(std::string_view scene);

/// The axes of an SPZ file that `option` names. Throws `InvalidArgument` if there are none so called.
SpzFrame spz_frame_named(const std::string& name, const std::string& option);

/// The scene and what lies beside it. Of the built-in scene only the name is there, `builtin:N`. Throws what
/// `find_capture` throws.
Capture capture_of(const SceneOptions& options);

/// Loads the file or makes the built-in scene.
SceneFile load(const SceneOptions& options, const swiftgs::Progress& progress = {});

/// A scene to draw.
struct DrawnScene {
  std::shared_ptr<const Scene> gaussians;
  std::optional<Camera> camera;  ///< that the file has
};

/// The same for a command that draws: says the file's notes, and adds them to `said` as `say_notes` does.
DrawnScene load_to_draw(const SceneOptions& options, std::vector<std::string>& said);

/// The cameras of `scene`: those that `--cameras` names, or else those in its folder where `scene` is the
/// folder of a capture. Empty where there are none.
std::string cameras_of(const SceneOptions& scene, const std::string& cameras);

/// The folder of photographs for `view` of `scene`: what `--photos` names, or else that in the folder of the
/// capture where its own cameras are taken. Empty where there is none.
std::string photos_of(const SceneOptions& scene, const ViewOptions& view, const std::string& photos);

}  // namespace swiftgs::cli
