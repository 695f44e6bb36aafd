// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include <swiftgs/frame/api.hpp>

namespace swiftgs {

/// A trained scene, its cameras and its photographs. An empty path means that the part is missing.
struct Capture {
  std::string name;               ///< of the scene: its file's without the ending
  std::filesystem::path scene;    ///< a file that `read_scene` takes
  std::filesystem::path cameras;  ///< what `read_cameras` takes
  std::filesystem::path photos;   ///< a folder of photographs that have the paths or names of images
};

/// Finds the parts of a capture. `path` is its folder, or the scene's file in it, which need not exist.
///
/// In a folder NAME the scene is the first of these that is there; endings may be in capitals:
/// - `point_cloud/iteration_N/point_cloud.ply` with the greatest N, which INRIA's training writes and which
///   takes the name of the folder,
/// - NAME with an ending of a format that docs/formats.md lists for captures, in its order,
/// - the only file with one of these endings. `input.ply` does not count: INRIA's training keeps its points
///   there,
/// - `lod-meta.json` or `meta.json` of a SOG, which take the name of the folder,
/// - NAME with an ending that the page lists behind these,
/// - the only file with one of those.
///
/// Cameras are a COLMAP model in the folder itself, `cameras.json`, a COLMAP model in `sparse/0`, `sparse` or
/// `0`, `transforms.json`, or one that ends in `_train`, `_test` or `_val`, the first that is there.
/// Photographs are in `photos`.
///
/// Throws `InvalidArgument` where a folder holds no scene, or several and none is called NAME.
SWIFTGS_API Capture find_capture(const std::filesystem::path& path);

}  // namespace swiftgs
