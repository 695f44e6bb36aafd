// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Files of cameras in memory. Each reader keeps the order of the file.

#include <cstdint>
#include <filesystem>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <swiftgs/camera.hpp>
#include <swiftgs/io/cameras.hpp>

#include "bytes.hpp"
#include "json_entry.hpp"

namespace swiftgs::io {

/// An INRIA `cameras.json`.
CameraFile parse_cameras_json(const Source& source);

/// nerfstudio's `camera_path.json`: the frames of a video in the world of the splats that it exports.
CameraFile parse_camera_path(const Source& source);

/// COLMAP's `cameras.bin` and `images.bin`.
std::vector<Camera> parse_colmap_binary(const Source& cameras, const Source& images);

/// COLMAP's `cameras.txt` and `images.txt`.
std::vector<Camera> parse_colmap_text(const Source& cameras, const Source& images);

/// Sets the pose of `camera` from its place in the world: the columns of `axes` are the directions of its own
/// axes there.
void set_pose(Camera& camera, const dmat3& axes, dvec3 centre);

/// The same with OpenGL's axes: y up, z backwards.
void set_opengl_pose(Camera& camera, const dmat3& axes, dvec3 centre);

/// Gives a camera of an equirectangular lens the intrinsics with which an image of so many pixels shows every
/// direction once.
void show_sphere(Camera& camera, double width, double height);

/// Width or height from a file's number. Throws `FormatError` at `offset` if no image has that many pixels.
int to_side(const Source& source, std::uint64_t offset, double pixels);

/// Throws `FormatError` at `offset` unless an image can be rendered with `camera`.
void expect_valid(const Source& source, std::uint64_t offset, const Camera& camera);

/// A camera of a JSON file, and the object around all cameras, whose members count where the camera has none
/// of its own.
struct CameraEntry {
  JsonEntry own, shared;

  /// Whichever has `key`; null if neither has.
  const JsonEntry* with(const char* key) const {
    return own.has(key) ? &own : shared.has(key) ? &shared : nullptr;
  }
};

/// The lens of a camera, by `camera_model`, instant-ngp's marks and the coefficients, each of which a camera
/// may have itself. Of FULL_OPENCV k4 to k6 are rational; elsewhere k4 is radial, as nerfstudio has it.
/// Throws `FormatError` that names the model, the coefficient or the mark that `Lens` cannot be.
Lens lens_of(const CameraEntry& entry);

/// The focal length with which an image side shows the angle in `key`.
double length_of_angle(const JsonEntry& entry, const char* key, double to_radians, int side);

/// Collects the keys of a camera file that nobody reads.
class UnreadKeys {
 public:
  /// `read` are the keys that the reader takes, and those that no picture shows.
  explicit UnreadKeys(std::span<const std::string_view> read) : read_(read) {}

  /// Adds the keys of `entry` that may change the picture: neither read, nor of a lens, nor switched off by
  /// 0, false, null or an empty value.
  void add(const JsonEntry& entry);

  void add(const std::string& key) { keys_.insert(key); }

  void note(std::vector<std::string>& notes) const;

 private:
  std::span<const std::string_view> read_;
  std::set<std::string> keys_;
};

/// Cameras in the order of the file. Where the file gives no size, the image in `folder` does; without
/// images `folder` is empty. `dataparser` is nerfstudio's `dataparser_transforms.json`,
/// which takes cameras to the world of the trained model, or null.
CameraFile parse_transforms_json(const Source& source, const std::filesystem::path& folder = {},
                                 const Source* dataparser = nullptr);

/// The same with the `dataparser_transforms.json` that is in `folder`, if there is one.
CameraFile read_transforms_json(const Source& source, const std::filesystem::path& folder);

}  // namespace swiftgs::io
