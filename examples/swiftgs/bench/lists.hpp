// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "options.hpp"

namespace swiftgs::cli {

/// A scene with what was captured beside it.
struct Input {
  SceneOptions scene;
  std::string cameras;  ///< or empty
  std::string photos;   ///< or empty
};

/// What `name` stands for: `builtin` or `builtin:N`; a scene's file; or the folder of a capture, which holds
/// one such file. Cameras are `cameras.json` or the COLMAP model `sparse/0` in the same folder, photographs
/// are in `photos`. Throws `std::invalid_argument` where there is none or more than one scene.
Input input_named(const std::string& name);

/// The parts of `text` between commas. Throws `std::invalid_argument`, naming `option`, for an empty one and
/// for one that is there twice.
std::vector<std::string> list_of(const std::string& option, const std::string& text);

/// The same as numbers.
std::vector<double> numbers_of(const std::string& option, const std::string& text);
std::vector<std::size_t> counts_of(const std::string& option, const std::string& text);

}  // namespace swiftgs::cli
