// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include <swiftgs/api.hpp>
#include <swiftgs/camera.hpp>

namespace swiftgs {

/// Reads cameras, sorted by image name. `path` is one of
/// - an INRIA `cameras.json`; its principal points are the image centres,
/// - the folder of a COLMAP sparse model, with `cameras` and `images`. The binary files are read if both are
///   there, the text files otherwise. Points are not needed,
/// - the folder of a capture that holds one of these, as `find_capture` says.
///
/// COLMAP's camera models PINHOLE and SIMPLE_PINHOLE are read; any other is refused by name. `Camera::name`
/// is the image's name as the file has it. Throws `FormatError`, `std::system_error` if something cannot be
/// read, and `std::invalid_argument` for a folder without cameras.
SWIFTGS_API std::vector<Camera> read_cameras(const std::filesystem::path& path);

}  // namespace swiftgs
