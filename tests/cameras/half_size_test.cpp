// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/metrics.hpp>
#include <swiftgs/swiftgs.hpp>
#include <swiftgs/tools/half_size_occluder.hpp>

using namespace swiftgs;

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

/// The mean of two by two pixels; of an odd side the last has one alone.
std::vector<float> halved(const Frame& whole) {
  std::vector<float> out;
  for (int y = 0; y < whole.height; y += 2)
    for (int x = 0; x < whole.width; x += 2)
      for (int channel = 0; channel < 3; ++channel) {
        double sum = 0, count = 0;
        for (int row = y; row < std::min(y + 2, whole.height); ++row)
          for (int column = x; column < std::min(x + 2, whole.width); ++column)
            sum += whole.colour[std::size_t(3 * (row * whole.width + column) + channel)], ++count;
        out.push_back(float(sum / count));
      }
  return out;
}

}  // namespace

TEST_CASE("half size: a frame without an occluder is refused") {
  CHECK_THROWS_WITH_AS(half_size_occluder({.width = 2, .height = 2}),
                       "half_size_occluder: the frame has no occluder, expected one", std::invalid_argument);
}

TEST_CASE("half size: each pixel has the middle of two by two") {
  for (const int width : {640, 641}) {
    const Camera camera = builtin_camera(width, 361), half = scaled(camera, 0.5);
    CHECK(half.width == (width + 1) / 2);
    CHECK(half.height == 181);
    const dvec3 p = camera.rotation * dvec3(0.2, -0.5, 0.1) + camera.translation;
    CHECK(half.fx * p.x / p.z + half.cx == doctest::Approx((camera.fx * p.x / p.z + camera.cx) / 2));
    CHECK(half.fy * p.y / p.z + half.cy == doctest::Approx((camera.fy * p.y / p.z + camera.cy) / 2));
  }
}

TEST_CASE("half size: the farthest of four pixels hides") {
  // Bottom row first, three by three, stored as 1 / depth.
  const float depths[3][3] = {{9, 8, 7}, {infinity, 5, 4}, {3, 2, 1}};
  float stored[3][3];
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 3; ++x) stored[y][x] = 1 / depths[y][x];
  FrameView whole{.width = 3, .height = 3};
  whole.occluder = {stored[2], -12}, whole.stored_depth = StoredDepth::perspective(infinity, 1);
  const std::vector<float> half = half_size_occluder(whole);
  REQUIRE(half.size() == 4);
  CHECK(half[0] == infinity);
  CHECK(half[1] == doctest::Approx(4));
  CHECK(half[2] == doctest::Approx(9));
  CHECK(half[3] == doctest::Approx(7));
  stored[2][2] = std::nanf("");
  CHECK(half_size_occluder(whole)[1] == infinity);
}

TEST_CASE("half size: a frame with an occluder is the whole one halved") {
  const int width = 241, height = 135;
  const Camera camera = builtin_camera(width, height);
  Renderer<Serial, EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse> renderer;
  const auto scene = renderer.backend().upload(make_builtin_scene(20'000));
  // A wall through the still life, and nothing in a hole of it.
  std::vector<float> wall(std::size_t(width * height));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      wall[std::size_t(y * width + x)] = x > 61 && x < 140 && y < 84 ? infinity : 4.2f;
  const auto drawn = [&](const Camera& by, const std::vector<float>& occluder) {
    Frame frame;
    FrameView view = prepare(frame, by.width, by.height, {});
    view.occluder = {occluder.data(), std::ptrdiff_t(sizeof(float)) * by.width};
    renderer.render_into(scene.view(), by, {}, view);
    return frame;
  };
  FrameView whole{.width = width, .height = height};
  whole.occluder = {wall.data(), std::ptrdiff_t(sizeof(float)) * width};
  const std::vector<float> expected = halved(drawn(camera, wall)), occluder = half_size_occluder(whole);
  const Camera half = scaled(camera, 0.5);
  // Sharp edges of splats are all that differs; what shows at a wrong depth or place is far more.
  CHECK(psnr(drawn(half, occluder).colour, expected) > 25);
  CHECK(psnr(drawn(half, std::vector<float>(occluder.size(), infinity)).colour, expected) < 20);
  std::vector<float> moved = occluder;
  std::rotate(moved.begin(), moved.begin() + 10, moved.end());
  CHECK(psnr(drawn(half, moved).colour, expected) < 24);
}
