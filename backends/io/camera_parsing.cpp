// SPDX-License-Identifier: Apache-2.0
#include "camera_parsing.hpp"

#include <cmath>
#include <numbers>
#include <string>

#include <glm/matrix.hpp>

#include <swiftgs/error.hpp>

namespace swiftgs::io {

void set_pose(Camera& camera, const dmat3& axes, dvec3 centre) {
  camera.rotation = glm::transpose(axes);
  camera.translation = dvec3(0.0);
  for (int column = 0; column < 3; ++column) camera.translation -= camera.rotation[column] * centre[column];
}

void set_opengl_pose(Camera& camera, const dmat3& axes, dvec3 centre) {
  set_pose(camera, dmat3(axes[0], -axes[1], -axes[2]), centre);
}

void show_sphere(Camera& camera, double width, double height) {
  camera.fx = width / (2 * std::numbers::pi), camera.fy = height / std::numbers::pi;
  camera.cx = 0.5 * width, camera.cy = 0.5 * height;
}

int to_side(const Source& source, std::uint64_t offset, double pixels) {
  if (!(pixels >= 1 && pixels <= max_image_side) || pixels != std::floor(pixels))
    source.fail(offset, "a width and a height of 1 to " + std::to_string(max_image_side) + " pixels");
  return int(pixels);
}

void expect_valid(const Source& source, std::uint64_t offset, const Camera& camera) {
  try {
    validate(camera);
  } catch (const InvalidArgument& error) {
    source.fail(offset, std::string("a camera that can be rendered with (") + error.what() + ")");
  }
}

}  // namespace swiftgs::io
