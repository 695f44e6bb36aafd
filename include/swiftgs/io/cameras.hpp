// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <swiftgs/camera.hpp>
#include <swiftgs/frame/api.hpp>

namespace swiftgs {

/// Cameras and what reading them brought up.
struct CameraFile {
  std::vector<Camera> cameras;
  /// What may change a picture and was not read, a sentence each.
  std::vector<std::string> notes;
  double frames_a_second = 0;  ///< of a path, whose cameras are the frames of a video; else 0
};

/// Reads cameras. `path` is one of
/// - an INRIA `cameras.json`; its principal points are the image centres unless it has `cx` and `cy`,
/// - a `transforms.json` of nerfstudio or instant-ngp, or Blender's `transforms_train.json`. Where it has no
///   `w` and `h`, the header of the frame's image beside it tells the size (`file_path`, or with `.png` where
///   that is not there). Cameras stay in the world of the file, unless nerfstudio's
///   `dataparser_transforms.json` lies beside it: then they are in the world of the splats that nerfstudio
///   exports,
/// - a `camera_path.json` of nerfstudio, whose cameras have no names and are in that same world,
/// - the folder of a COLMAP sparse model, with `cameras` and `images`. The binary files are read if both are
///   there, the text files otherwise. Points are not needed,
/// - the folder of a capture that holds one of these, as `find_capture` says.
///
/// `Camera::lens` is what the file says. COLMAP's models SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL,
/// OPENCV, FULL_OPENCV, OPENCV_FISHEYE, SIMPLE_RADIAL_FISHEYE, RADIAL_FISHEYE, THIN_PRISM_FISHEYE,
/// SIMPLE_FISHEYE, FISHEYE and EQUIRECTANGULAR, which forks call SPHERICAL, are read, and as the
/// `camera_model` of a JSON file also ORTHOPHOTO. The equirectangular image of a JSON file shows the whole
/// sphere. FOV, the division models, EUCM and RAD_TAN_THIN_PRISM_FISHEYE are read where their coefficients
/// make them one of these lenses. Any other is refused by name where an image uses it.
///
/// Texts are in UTF-8, with a byte order mark or without. A file of anything else is refused with what it is.
///
/// `Camera::name` is the image's name as the file has it. Cameras of a transforms.json or a path keep the
/// order of the file, others are sorted by name. Throws `FormatError`, `FileError` if something
/// cannot be read, and `InvalidArgument` for a folder without cameras.
SWIFTGS_API CameraFile read_cameras(const std::filesystem::path& path);

/// `read_cameras(path).cameras`.
SWIFTGS_API std::vector<Camera> load_cameras(const std::filesystem::path& path);

}  // namespace swiftgs
