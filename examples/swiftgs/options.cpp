// SPDX-License-Identifier: Apache-2.0
#include "options.hpp"

#include <CLI/CLI.hpp>

namespace swiftgs::cli {

void add_scene(CLI::App& command, SceneOptions& options) {
  command.add_option("SCENE", options.scene, "A .ply or .spz file, builtin, or builtin:N for N Gaussians")
      ->required();
  command
      .add_option("--spz-frame", options.spz_frame,
                  "Axes of an .spz file: specified (what the file says), rub, rdf, luf or raw")
      ->capture_default_str();
}

void add_cameras(CLI::App& command, ViewOptions& options) {
  command.add_option("--cameras", options.cameras, "A cameras.json, or a folder with a COLMAP model");
  command
      .add_option("--conventions", options.conventions, "gsplat or inria: what the scene was trained with")
      ->capture_default_str();
}

void add_views(CLI::App& command, ViewOptions& options, const std::string& default_views) {
  add_cameras(command, options);
  const auto given = [](const std::string& views) {
    return std::string(views.empty() ? "expected views, found nothing" : "");
  };
  command
      .add_option("--views", options.views,
                  "Which: numbers as 0,8 or 3-7, or every:8, or except:8, or all [" + default_views +
                      " with cameras, else 0]")
      ->check(given);
  command.add_option("--scale", options.scale, "Factor of the image's sides")->capture_default_str();
  command.add_option("--background", options.background, "R,G,B, each 0 to 1")->capture_default_str();
}

void add_calibration(CLI::App& command, std::string& file) {
  command.add_option("--calibration", file,
                     "For renderers with the sort 'adaptive': what 'swiftgs calibrate' wrote\n"
                     "[SCENE.sort.json where it is there]");
}

}  // namespace swiftgs::cli
