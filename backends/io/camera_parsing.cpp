// SPDX-License-Identifier: Apache-2.0
#include "camera_parsing.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

#include <glm/matrix.hpp>

namespace swiftgs::io {

void set_intrinsics(Camera& camera, const double* parameters, int count) {
  const bool simple = count == 3;
  camera.fx = parameters[0];
  camera.fy = parameters[simple ? 0 : 1];
  camera.cx = parameters[simple ? 1 : 2];
  camera.cy = parameters[simple ? 2 : 3];
}

void set_pose(Camera& camera, const dmat3& axes, dvec3 centre) {
  camera.rotation = glm::transpose(axes);
  camera.translation = dvec3(0.0);
  for (int column = 0; column < 3; ++column) camera.translation -= camera.rotation[column] * centre[column];
}

int to_side(const Source& source, std::uint64_t offset, double pixels) {
  if (!(pixels >= 1 && pixels <= max_image_side) || pixels != std::floor(pixels))
    source.fail(offset, "a width and a height of 1 to " + std::to_string(max_image_side) + " pixels");
  return int(pixels);
}

Camera place(const Source& images, std::uint64_t offset, const ColmapIntrinsics& intrinsics,
             const ColmapPose& pose, std::string_view name) {
  const auto found = intrinsics.find(pose.camera_id);
  if (found == intrinsics.end())
    images.fail(offset, "the id of a known camera, found " + std::to_string(pose.camera_id));
  Camera camera = found->second;
  camera.name = name;
  camera.translation = pose.translation;

  const double length = std::sqrt(pose.w * pose.w + pose.x * pose.x + pose.y * pose.y + pose.z * pose.z);
  if (!(length > 0) || !std::isfinite(length))
    images.fail(offset, "a quaternion with a finite length above 0");
  const double w = pose.w / length, x = pose.x / length, y = pose.y / length, z = pose.z / length;
  camera.rotation[0] = {1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)};
  camera.rotation[1] = {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)};
  camera.rotation[2] = {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)};
  expect_valid(images, offset, camera);
  return camera;
}

void expect_valid(const Source& source, std::uint64_t offset, const Camera& camera) {
  try {
    validate(camera);
  } catch (const std::invalid_argument& error) {
    source.fail(offset, std::string("a camera that can be rendered with (") + error.what() + ")");
  }
}

}  // namespace swiftgs::io
