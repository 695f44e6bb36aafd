// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numbers>
#include <vector>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/camera.hpp>

namespace swiftgs::test {

/// Cameras at one place of the built-in scene, through every lens.
inline std::vector<Camera> cameras_of_lenses(int width = 160, int height = 96) {
  constexpr double turn = 2 * std::numbers::pi;
  const Camera pinhole = builtin_camera(width, height);
  std::vector<Camera> cameras(6, pinhole);
  cameras[1].lens.distortion = {{-0.2, 0.03, 0, 0}, {}, {0.002, -0.003}, {}};
  cameras[2].lens.model = LensModel::fisheye;
  cameras[2].fx = cameras[2].fy = width / 4.0;  // shows 229 degrees
  cameras[3] = cameras[2];
  cameras[3].lens.distortion = {{0.02, -0.004, 0.001, 0}, {}, {}, {0.001, -0.002}};
  cameras[4].lens.model = LensModel::orthographic;
  cameras[4].fx = cameras[4].fy = 0.2 * pinhole.fx;
  cameras[5].lens.model = LensModel::equirectangular;
  cameras[5].fx = width / turn, cameras[5].fy = 2 * height / turn;
  return cameras;
}

}  // namespace swiftgs::test
