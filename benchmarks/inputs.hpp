// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <swiftgs/camera.hpp>
#include <swiftgs/scene.hpp>

namespace swiftgs::bench {

/// What a benchmark renders. Cameras are known at once, because image sizes are part of the names; the
/// Gaussians are loaded when a benchmark first runs.
struct Input {
  std::string name;           ///< `builtin`, `builtin:N`, or the capture's
  std::vector<Camera> views;  ///< every eighth of a capture's by image name, from the first; never empty
  std::function<Scene()> load;

  std::string size() const;  ///< of the first view, as `1297x840`
};

/// The inputs called `names`; without names the built-in scene and every capture.
///
/// Captures with cameras, as `find_capture` knows them, are looked for in the folder that the environment
/// variable SWIFTGS_SCENES names, or else the build did; there may be none. Throws `std::invalid_argument`,
/// naming what there is, for a name that is not known, and what `load_cameras` throws.
std::vector<Input> inputs_named(const std::vector<std::string>& names);

}  // namespace swiftgs::bench
