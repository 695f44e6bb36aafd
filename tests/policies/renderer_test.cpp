// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <vector>

#include <doctest/doctest.h>

#include "policies/rasterizers.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

template <class B>
using AnyOf = Renderer<B, EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse>;

Scene giants(int count) {
  Scene scene;
  for (int i = 0; i < count; ++i) {
    scene.means.push_back(vec3(0, 0, 1));
    scene.scales.push_back(vec3(1000));
    scene.rotations.push_back({});
    scene.opacities.push_back(1);
    scene.sh0.push_back(vec3(1));
  }
  return scene;
}

}  // namespace

TEST_CASE_TEMPLATE("renderer: is usable after a frame that needs too many intersections", B,
                   SWIFTGS_TEST_BACKENDS) {
  AnyOf<B> renderer(make_backend<B>());
  const auto flood = renderer.backend().upload(giants(129));
  const auto scene = renderer.backend().upload(random_scene(100, 1, 1));
  const Camera huge = forward_camera(max_image_side, max_image_side), camera = forward_camera(50, 40);
  const Frame expected = renderer.render(scene, camera);
  // No output is asked for, so the frame itself takes no memory.
  const FrameView nothing{.width = huge.width, .height = huge.height};
  CHECK_THROWS_AS(renderer.render_into(flood.view(), huge, {}, nothing), CapacityError);
  CHECK(renderer.render(scene, camera).colour == expected.colour);
}

TEST_CASE_TEMPLATE("renderer: an empty scene is the background", B, SWIFTGS_TEST_BACKENDS) {
  AnyOf<B> renderer(make_backend<B>());
  RenderSettings settings;
  settings.background = vec3(0.5f, 0.25f, 2), settings.outputs = {true, true}, settings.count = true;
  const Frame frame = renderer.render(renderer.backend().upload(Scene()), forward_camera(20, 3), settings);
  for (std::size_t i = 0; i < frame.pixels(); ++i) {
    CHECK(frame.colour[3 * i + 2] == 2);
    CHECK(frame.alpha[i] == 0);
    CHECK(frame.depth[i] == 0);
  }
  const Statistics statistics = renderer.statistics();
  CHECK(statistics.gaussians == 0);
  CHECK(statistics.visible == 0);
  CHECK(statistics.intersections == 0);
  CHECK(statistics.intersections_a_visible() == 0);
}

TEST_CASE_TEMPLATE("renderer: counts what it did", B, SWIFTGS_TEST_BACKENDS) {
  AnyOf<B> renderer(make_backend<B>());
  const Scene scene = random_scene(300, 0, 2);
  RenderSettings settings;
  settings.count = settings.time = true;
  const auto uploaded = renderer.backend().upload(scene);
  renderer.render(uploaded, forward_camera(80, 60), settings);
  const Statistics statistics = renderer.statistics();
  CHECK(statistics.gaussians == 300);
  CHECK(statistics.visible > 50);
  CHECK(statistics.visible < 300);
  CHECK(statistics.intersections >= statistics.visible);
  CHECK(statistics.intersections_a_visible() ==
        doctest::Approx(double(statistics.intersections) / double(statistics.visible)));
  CHECK(statistics.raster.intersections_visited <= statistics.intersections);
  CHECK(statistics.raster.contributing_pairs > 1000);
  const StageTimes times = renderer.times();
  CHECK(times.project >= 0);
  CHECK(times.total == doctest::Approx(times.project + times.sort + times.raster));
  CHECK(statistics.balanced_ms() > 0);
  CHECK(statistics.balanced_ms() <= times.raster);
  settings.count = false;
  renderer.render(uploaded, forward_camera(80, 60), settings);
  CHECK(renderer.statistics().balanced_ms() == 0);
}

TEST_CASE("renderer: one frame may be written into a part of a larger image") {
  AnyOf<Serial> renderer;
  const auto scene = renderer.backend().upload(random_scene(100, 0, 3));
  const Camera camera = forward_camera(30, 20);
  const Frame alone = renderer.render(scene, camera);
  std::vector<float> wall(3 * 100 * 50, -1);
  float* const corner = wall.data() + 3 * (10 * 100 + 40);
  renderer.render_into(scene.view(), camera, {}, {.width = 30, .height = 20, .colour = {corner, 1200}});
  CHECK(corner[0] == alone.colour[0]);
  CHECK(corner[300 * 19 + 89] == alone.colour[3 * 20 * 30 - 1]);
  CHECK(corner[-1] == -1);
  CHECK(corner[90] == -1);
}

TEST_CASE("renderer: what nothing can be rendered with is refused in words") {
  AnyOf<Serial> renderer;
  const Scene scene = random_scene(10, 2, 4);
  struct Arguments {
    SceneView scene;
    Camera camera;
    RenderSettings settings;
    FrameView frame;
  };
  std::vector<float> memory(3 * 40 * 30);
  const auto refusal = [&](const std::function<void(Arguments&)>& spoil) {
    Arguments a{
        view(scene), forward_camera(40, 30), {}, {.width = 40, .height = 30, .colour = {memory.data(), 480}}};
    spoil(a);
    try {
      renderer.render_into(a.scene, a.camera, a.settings, a.frame);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  CHECK(refusal([](Arguments&) {}) == "accepted");
  CHECK(refusal([](Arguments& a) { a.frame.width = 39; }) == "render: expected a frame of the camera's size");
  CHECK(refusal([](Arguments& a) { a.frame.colour.pitch = 476; }) ==
        "render: the pitch of colour is 476 bytes, expected at least 480 up or down, a multiple of 4");
  CHECK(refusal([&](Arguments& a) {
          a.frame.alpha = {memory.data(), 159};
        }) == "render: the pitch of alpha is 159 bytes, expected at least 160 up or down, a multiple of 4");
  CHECK(refusal([&](Arguments& a) {
          a.frame.depth = {memory.data(), 0};
        }) == "render: the pitch of depth is 0 bytes, expected at least 160 up or down, a multiple of 4");
  CHECK(refusal([](Arguments& a) { a.camera.width = a.frame.width = -100, a.settings.count = true; }) ==
        "camera: expected a width and a height above 0");
  CHECK(refusal([](Arguments& a) { a.camera.fx = std::nan(""); }) ==
        "camera: expected focal lengths of 1e-6 to 1e12 pixels");
  CHECK(refusal([](Arguments& a) { a.scene.opacities.size = 9; }) ==
        "render: expected arrays of one length in the scene");
  CHECK(refusal([](Arguments& a) { a.scene.sh_degree = 4; }) == "render: expected an SH degree of 0 to 3");
  CHECK(refusal([](Arguments& a) { a.scene.sh_degree = 3; }) ==
        "render: expected SH coefficients of the view's degree for every Gaussian");
  CHECK(refusal([](Arguments& a) { --a.scene.sh_rest.size; }) ==
        "render: expected SH coefficients of the view's degree for every Gaussian");
  for (const float alpha_min : {0.0f, 1e-42f, 0.995f, NAN})
    CHECK(refusal([&](Arguments& a) { a.settings.conventions.alpha_min = alpha_min; }) ==
          "conventions: expected 2^-126 <= alpha_min <= alpha_max <= 1");
  CHECK(refusal([](Arguments& a) { a.settings.conventions.blur = -1; }) ==
        "conventions: expected a blur of 0 or more");
  CHECK(refusal([](Arguments& a) { a.settings.conventions.near_plane = NAN; }) ==
        "conventions: expected a near plane of 0 or more before the far plane");
  CHECK(refusal([](Arguments& a) { a.settings.conventions.stop = 1; }) ==
        "conventions: expected a stop of 0 or more and below 1");
}

TEST_CASE_TEMPLATE("renderer: its memory is that of its stages and grows only with the frame", B,
                   SWIFTGS_TEST_BACKENDS) {
  AnyOf<B> renderer(make_backend<B>());
  CHECK(renderer.memory().total() == 0);
  const auto scene = renderer.backend().upload(random_scene(1000, 1, 1));
  const Camera small = forward_camera(50, 40), large = scaled(small, 4);
  // Buffers that a sort reads and writes in turn have grown after two frames.
  for (int frame = 0; frame < 3; ++frame) renderer.render(scene, large);
  const StageMemory memory = renderer.memory();
  const Statistics statistics = renderer.statistics();
  CHECK(memory.project >= statistics.visible * (sizeof(SplatShape) + sizeof(SplatColour) + sizeof(float) +
                                                sizeof(std::uint32_t)));
  CHECK(memory.sort >= statistics.intersections * sizeof(std::uint32_t));
  CHECK(memory.raster == 0);
  renderer.render(scene, small);
  CHECK(renderer.memory().total() == memory.total());
  renderer.render_resident(scene.view(), large, {});
  CHECK(renderer.memory().raster >= 3 * sizeof(float) * 200 * 160);
}

namespace {
/// Counts how often it is asked for the time.
struct Watched : Serial {
  int asked = 0;

  TimePoint now() {
    ++asked;
    return Serial::now();
  }
  template <class Key>
  void sort_pairs(Pairs<Watched, Key>& pairs, Count n, int bits) const {
    Pairs<Serial, Key> same{std::move(pairs.keys), std::move(pairs.spare_keys), std::move(pairs.values),
                            std::move(pairs.spare_values)};
    Serial::sort_pairs(same, n, bits);
    pairs = {std::move(same.keys), std::move(same.spare_keys), std::move(same.values),
             std::move(same.spare_values)};
  }
};
}  // namespace

TEST_CASE("renderer: a frame asks for no time unless its settings do") {
  Renderer<Watched, EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse> renderer;
  const auto scene = renderer.backend().upload(random_scene(100, 0, 3));
  const Camera camera = forward_camera(30, 20);
  RenderSettings timing;
  timing.time = true;
  CHECK(std::isnan(renderer.times().total));
  renderer.render(scene, camera, timing);
  CHECK(renderer.backend().asked == 4);
  CHECK(renderer.times().total >= 0);
  renderer.render(scene, camera);
  CHECK(renderer.backend().asked == 4);
  CHECK(std::isnan(renderer.times().total));  // not those of the frame before
}
