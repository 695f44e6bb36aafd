// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string_view>
#include <vector>

#include <swiftgs/camera.hpp>

#include "bytes.hpp"

/// @file
/// Camera files in memory, each in the order of the file.

namespace swiftgs::io {

/// An INRIA `cameras.json`.
std::vector<Camera> parse_cameras_json(const Source& source);

/// COLMAP's `cameras.bin` and `images.bin`.
std::vector<Camera> parse_colmap_binary(const Source& cameras, const Source& images);

/// COLMAP's `cameras.txt` and `images.txt`.
std::vector<Camera> parse_colmap_text(const Source& cameras, const Source& images);

/// Intrinsics by COLMAP's camera id.
using ColmapIntrinsics = std::map<std::uint32_t, Camera>;

/// A pose as COLMAP writes it: world to camera, Hamilton quaternion, scalar part first, of any length.
struct ColmapPose {
  double w, x, y, z;
  dvec3 translation;
  std::uint32_t camera_id;
};

/// Sets size and intrinsics of `camera` from a PINHOLE (fx, fy, cx, cy) or a SIMPLE_PINHOLE (f, cx, cy).
void set_intrinsics(Camera& camera, const double* parameters, int count);

/// Sets the pose of `camera` from its place in the world: the columns of `axes` are the directions of its own
/// axes there.
void set_pose(Camera& camera, const dmat3& axes, dvec3 centre);

/// Width or height from a file's number. Throws `FormatError` at `offset` if no image has that many pixels.
int to_side(const Source& source, std::uint64_t offset, double pixels);

/// The camera of one image. Throws `FormatError` at `offset` if its id is unknown or it cannot be rendered
/// with.
Camera place(const Source& images, std::uint64_t offset, const ColmapIntrinsics& intrinsics,
             const ColmapPose& pose, std::string_view name);

/// Throws `FormatError` at `offset` unless an image can be rendered with `camera`.
void expect_valid(const Source& source, std::uint64_t offset, const Camera& camera);

}  // namespace swiftgs::io
