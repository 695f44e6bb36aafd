// SPDX-License-Identifier: Apache-2.0

// Lenses: a pinhole without and with distortion, a fisheye, an orthographic view and a panorama of one scene,
// drawn in one frame. The images are written as PNG into the folder that is given.
#include <cstddef>
#include <exception>
#include <filesystem>
#include <iostream>
#include <numbers>
#include <vector>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/cpu.hpp>
#include <swiftgs/io/image.hpp>
#include <swiftgs/swiftgs.hpp>

using namespace swiftgs;

namespace {

/// All that is in front of the camera: an angle of 90 degrees is half the side from the centre.
Camera fisheye() {
  constexpr int side = 640;
  Camera camera = builtin_camera(side, side);
  camera.lens.model = LensModel::fisheye;
  camera.fx = camera.fy = side / std::numbers::pi;
  camera.name = "fisheye";
  return camera;
}

Camera pinhole() {
  Camera camera = builtin_camera(800, 450);
  camera.name = "pinhole";
  return camera;
}

/// A cheap wide-angle lens, with the coefficients that OpenCV's calibration finds.
Camera distorted_pinhole() {
  Camera camera = pinhole();
  camera.lens.distortion = {.radial = {-0.22, 0.05}, .tangential = {0.002, -0.001}};
  camera.name = "distorted";
  return camera;
}

/// What is as far away as the still life, 4 metres, has the size that it has in a pinhole.
Camera orthographic() {
  constexpr double distance = 4.0;  // in metres
  Camera camera = builtin_camera(800, 450);
  camera.lens.model = LensModel::orthographic;
  camera.fx /= distance, camera.fy /= distance;
  camera.name = "orthographic";
  return camera;
}

/// All around: a turn is the width, from straight up to straight down the height.
Camera panorama() {
  constexpr int height = 400;
  Camera camera = builtin_camera(2 * height, height);
  camera.lens.model = LensModel::equirectangular;
  camera.fx = camera.fy = height / std::numbers::pi;
  camera.name = "panorama";
  return camera;
}

}  // namespace

int main(int argc, char** argv) try {
  Renderer<Cpu, EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse> renderer;
  const Cpu::SceneOn scene = renderer.backend().upload(make_builtin_scene());
  RenderSettings settings;
  settings.background = vec3(0.10f, 0.12f, 0.15f);
  settings.outputs = {.alpha = true, .depth = false};

  // One projection, one sort and one rasterization, whatever the sizes and lenses.
  const std::vector<Camera> cameras{pinhole(), distorted_pinhole(), fisheye(), orthographic(), panorama()};
  std::vector<Frame> frames(cameras.size());
  renderer.render(scene, {cameras.data(), cameras.size()}, settings, {frames.data(), frames.size()});

  bool right = true;
  for (std::size_t view = 0; view < cameras.size(); ++view) {
    const Frame& frame = frames[view];
    double covered = 0;
    for (const float alpha : frame.alpha) covered += double(alpha);
    covered /= double(frame.alpha.size());
    // A view has the bits that it has alone.
    const Frame alone = renderer.render(scene, cameras[view], settings);
    right = right && covered > 0.1 && frame.colour == alone.colour;
    std::cout << cameras[view].name << ": " << renderer.statistics().visible << " Gaussians in view cover "
              << int(100 * covered) << "% of " << frame.width << "x" << frame.height << " pixels\n";
    if (argc > 1) write_png(std::filesystem::path(argv[1]) / (cameras[view].name + ".png"), frame);
  }
  return right ? 0 : 1;
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
