// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include <swiftgs/io/cameras.hpp>

#include "bytes.hpp"

/// @file
/// Camera files in memory, each in the order of the file.

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

}  // namespace swiftgs::io
