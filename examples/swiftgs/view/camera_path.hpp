// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include <swiftgs/camera.hpp>
#include <swiftgs/frame/math.hpp>

namespace swiftgs::cli {

/// A flight of a camera past keys, by the same time from each to the next.
struct CameraPath {
  std::vector<Camera> keys;  ///< of which place, direction and vertical angle count
  double seconds_a_key = 2;
  double frames_a_second = 24;

  double seconds() const { return keys.size() < 2 ? 0 : seconds_a_key * double(keys.size() - 1); }
};

/// The pinhole camera `seconds` after the first key, in an image of this size: on a smooth curve through all
/// keys. Before the first and after the last it stands. Expects one key or more.
Camera camera_at(const CameraPath& path, double seconds, int width, int height);

/// Writes a `camera_path.json` of nerfstudio: the keys, and every frame. `origin` is added to all places.
/// Throws `FileError` if the file cannot be written.
void write_camera_path(const std::filesystem::path& file, const CameraPath& path, int width, int height,
                       const dvec3& origin);

/// Whether a file is a path rather than a scene.
bool is_camera_path(const std::filesystem::path& file);

/// Reads a `camera_path.json`: its keys where it has them, else its frames. Subtracts `origin` from all
/// places. Throws as `read_cameras`, and `InvalidArgument` for no camera.
CameraPath read_camera_path(const std::filesystem::path& file, const dvec3& origin);

}  // namespace swiftgs::cli
