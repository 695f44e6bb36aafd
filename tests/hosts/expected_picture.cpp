// SPDX-License-Identifier: Apache-2.0

// Compares a screenshot of an example that draws a box and the built-in scene with the picture that the
// library composes of a box that this program traces. The camera's matrices and the depths of the box come
// from none that the examples use.
//
//     expected_picture SCREENSHOT.png [EXPECTED.png]
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>
#include <vector>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/cpu.hpp>
#include <swiftgs/io/image.hpp>
#include <swiftgs/metrics.hpp>
#include <swiftgs/swiftgs.hpp>

using namespace swiftgs;

namespace {

constexpr float nowhere = std::numeric_limits<float>::infinity();

struct Surface {
  float depth = nowhere;
  dvec3 colour{0};
};

/// Where the ray through a pixel enters the box.
Surface trace_box(const Camera& camera, int x, int y) {
  const dvec3 seen((x + 0.5 - camera.cx) / camera.fx, (y + 0.5 - camera.cy) / camera.fy, 1);
  const dvec3 half(0.55, 0.2, 0.2), from = camera.centre() - dvec3(0.02, -1.16, 0.02),
                                    along = seen * camera.rotation;
  double enter = 0, leave = nowhere;
  int face = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = (-half[axis] - from[axis]) / along[axis];
    const double high = (half[axis] - from[axis]) / along[axis];
    if (std::fmin(low, high) > enter) enter = std::fmin(low, high), face = 2 * axis + (high < low);
    leave = std::fmin(leave, std::fmax(low, high));
  }
  if (enter >= leave) return {};
  return {float(enter), dvec3(0.9, 0.55, 0.15) * (0.4 + 0.1 * face)};
}

}  // namespace

int main(int argc, char** argv) {
  const Image screenshot = read_image(argv[1]);
  const double turn = -0.26, rise = 0.2;
  const dvec3 target(0.02, -1.16, 0.02);
  const dvec3 away(std::sin(turn) * std::cos(rise), -std::sin(rise), -std::cos(turn) * std::cos(rise));
  const Camera camera = look_at(target + 3.0 * away, target, dvec3(0, -1, 0), 0.76, 960, 540);
  if (screenshot.width != camera.width || screenshot.height != camera.height || screenshot.channels != 3) {
    std::printf("the screenshot has %d x %d pixels of %d channels, expected 960 x 540 of 3\n",
                screenshot.width, screenshot.height, screenshot.channels);
    return 1;
  }
  std::vector<float> box, depth, box_before_all;
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const Surface surface = trace_box(camera, x, y);
      for (int c = 0; c < 3; ++c) box.push_back(float(surface.colour[c]));
      depth.push_back(surface.depth);
      box_before_all.push_back(surface.depth == nowhere ? nowhere : 0);
    }

  Renderer<Cpu> renderer;
  const Cpu::SceneOn scene = renderer.backend().upload(make_builtin_scene());
  const auto compose = [&](const std::vector<float>& occluder) {
    Frame frame;
    FrameView view = prepare(frame, camera.width, camera.height, {});
    frame.colour = box, view.colour.data = frame.colour.data(), view.over = true;
    if (!occluder.empty()) view.occluder = {occluder.data(), std::ptrdiff_t(sizeof(float)) * camera.width};
    renderer.render_into(scene.view(), camera, {}, view);
    for (float& value : frame.colour) value = std::fmin(value, 1.0f);  // as in 8 bits
    return frame;
  };
  const Frame expected = compose(depth);
  if (argc > 2) write_png(argv[2], expected);

  const double close = psnr(screenshot.pixels, expected.colour);
  const double box_behind = psnr(screenshot.pixels, compose({}).colour);
  const double box_before = psnr(screenshot.pixels, compose(box_before_all).colour);
  std::printf("%.1f dB; beside pictures with the box behind all splats %.1f dB, before all %.1f dB\n", close,
              box_behind, box_before);
  return close >= 30 && box_behind < 25 && box_before < 25 ? 0 : 1;
}
