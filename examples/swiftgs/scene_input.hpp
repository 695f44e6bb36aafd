// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include <swiftgs/io/scene_file.hpp>

#include "options.hpp"

namespace swiftgs::cli {

/// Gaussians that `scene` asks of the built-in scene, or nothing if it names a file. Throws
/// `std::invalid_argument` for `builtin:` with anything but a number.
std::optional<std::size_t> builtin_size(std::string_view scene);

/// The file of the scene; empty for the built-in one.
std::string file_of(const SceneOptions& options);

/// Loads the file or makes the built-in scene.
SceneFile load(const SceneOptions& options);

/// What tables call the scene: `builtin:N`, or the file's name without folder and extension.
std::string scene_label(const std::string& scene);

}  // namespace swiftgs::cli
