// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/metrics.hpp>
#include <swiftgs/reference.hpp>

#include "policies/contribution_sums.hpp"
#include "policies/rasterizers.hpp"

namespace swiftgs::test::renderer_test {

SWIFTGS_CONTRACT("renderer: is usable after a frame that needs too many intersections") {
  Usual<B> renderer(std::move(backend));
  const auto flood = renderer.backend().upload(giants_of(129));
  const auto scene = renderer.backend().upload(random_scene(100, 1, 1));
  const Camera huge = forward_camera(max_image_side, max_image_side), camera = forward_camera(50, 40);
  const Frame expected = renderer.render(scene, camera);
  // No output is asked for, so the frame itself takes no memory.
  const FrameView nothing{.width = huge.width, .height = huge.height};
  CHECK_THROWS_AS(renderer.render_into(flood.view(), huge, {}, nothing), CapacityError);
  CHECK(same_bits(renderer.render(scene, camera).colour, expected.colour));
}

SWIFTGS_CONTRACT("renderer: counts what it did and says how long it took") {
  Usual<B> renderer(std::move(backend));
  Usual<Serial> serial;
  RenderSettings settings;
  settings.count = settings.time = true;
  for (const std::size_t count : {300, 3000}) {
    if (count == 300 && !on_host<B>) continue;  // of so few, one more at the border of the image is many
    CAPTURE(count);
    const Scene scene = random_scene(count, 0, 2);
    const Camera camera = count == 300 ? forward_camera(80, 60) : forward_camera(180, 160);
    const auto uploaded = renderer.backend().upload(scene);
    renderer.render(uploaded, camera, settings);
    serial.render(serial.backend().upload(scene), camera, settings);
    const Statistics statistics = renderer.statistics(), expected = serial.statistics();
    CHECK(statistics.gaussians == count);
    CHECK(expected.visible > count / 6);
    CHECK(expected.visible < count);
    CHECK(std::abs(double(statistics.visible) - double(expected.visible)) <= 1);
    CHECK(double(statistics.intersections) == doctest::Approx(double(expected.intersections)).epsilon(1e-3));
    CHECK(statistics.intersections >= statistics.visible);
    CHECK(statistics.intersections_a_visible() ==
          doctest::Approx(double(statistics.intersections) / double(statistics.visible)));
    CHECK(statistics.raster.intersections_visited <= statistics.intersections);
    CHECK(expected.raster.contributing_pairs > 1000);
    CHECK(double(statistics.raster.contributing_pairs) ==
          doctest::Approx(double(expected.raster.contributing_pairs)).epsilon(1e-3));
    const StageTimes times = renderer.times();
    for (const double stage : {times.project, times.sort, times.raster})
      CHECK((on_host<B> ? stage >= 0 : stage > 0));
    CHECK(times.total ==
          doctest::Approx(times.project + times.sort + times.raster).epsilon(on_host<B> ? 1e-5 : 0.05));
    renderer.render(uploaded, camera);
    CHECK(renderer.statistics().raster.contributing_pairs == 0);
  }
}

SWIFTGS_CONTRACT("renderer: one renderer draws scenes and sizes in any order as new ones do") {
  Usual<B> renderer(std::move(backend));
  struct View {
    std::size_t gaussians;
    int width, height;
  };
  for (const View& view : {View{100, 60, 40},
                           {6000, 300, 200},
                           {50, 20, 20},
                           {9000, 310, 210},
                           {0, 64, 64},
                           {9000, 100, 300},
                           {30'000, 640, 400},
                           {300, 1, 1}}) {
    CAPTURE(view.gaussians);
    const auto scene = renderer.backend().upload(random_scene(view.gaussians, 1, view.gaussians + 1));
    const Camera camera = forward_camera(view.width, view.height);
    Usual<B> fresh(test::make_backend<B>());
    CHECK(same_bits(renderer.render(scene, camera).colour, fresh.render(scene, camera).colour));
  }
}

TEST_CASE("renderer: what nothing can be rendered with is refused in words") {
  Usual<Serial> renderer;
  Scene scene = with_features(random_scene(10, 2, 4), 3);
  struct Arguments {
    SceneView scene;
    Camera camera;
    RenderSettings settings;
    FrameView frame;
  };
  struct Refused {
    const char* why;
    void (*spoil)(Arguments&);
  };
  const char* const alphas = "conventions: expected 2^-126 <= alpha_min <= alpha_max <= 1";
  const Refused all[] = {
      {"expected a frame of the camera's size", [](Arguments& a) { a.frame.width = 39; }},
      {"expected a width and a height above 0",
       [](Arguments& a) { a.camera.width = a.frame.width = -100, a.settings.count = true; }},
      {"expected focal lengths of 1e-6 to 1e12 pixels", [](Arguments& a) { a.camera.fx = std::nan(""); }},
      {"opacities of the scene: 9 values, 4 bytes apart; expected 10 values",
       [](Arguments& a) { a.scene.opacities.size = 9; }},
      {"scales of the scene: 10 values, 8 bytes apart; expected 10 values, 12 bytes or more apart",
       [](Arguments& a) { a.scene.scales.stride = 8; }},
      {"rotations of the scene: 10 values, 18 bytes apart; expected 10 values, 16 bytes or more apart",
       [](Arguments& a) { a.scene.rotations.stride = 18; }},
      {"means of the scene: 0 values, ", [](Arguments& a) { a.scene.means.data = nullptr; }},
      {"sh_rest of the scene: 10 values, 96 bytes apart; expected 10 values, 180 bytes",
       [](Arguments& a) { a.scene.sh_degree = 3; }},
      {"sh_rest of the scene: 9 values, 96 bytes apart; expected 10",
       [](Arguments& a) { --a.scene.sh_rest.size; }},
      {"features of the scene: 9 values, 12 bytes apart; expected 10",
       [](Arguments& a) { --a.scene.features.size; }},
      {"expected an SH degree of 0 to 3", [](Arguments& a) { a.scene.sh_degree = 4; }},
      {alphas, [](Arguments& a) { a.settings.conventions.alpha_min = 0; }},
      {alphas, [](Arguments& a) { a.settings.conventions.alpha_min = 1e-42f; }},
      {alphas, [](Arguments& a) { a.settings.conventions.alpha_min = 0.995f; }},
      {alphas, [](Arguments& a) { a.settings.conventions.alpha_min = NAN; }},
      {"expected a blur of 0 or more", [](Arguments& a) { a.settings.conventions.blur = -1; }},
      {"expected a near plane of 0 or more before the far plane",
       [](Arguments& a) { a.settings.conventions.near_plane = NAN; }},
      {"expected a first alpha of 0 or more",
       [](Arguments& a) { a.settings.conventions.first_alpha = -0.1f; }},
      {"expected a first alpha of 0 or more", [](Arguments& a) { a.settings.conventions.first_alpha = 1; }},
      {"expected a stop of 0 or more and below 1", [](Arguments& a) { a.settings.conventions.stop = 1; }}};
  std::vector<float> memory(3 * 40 * 30);
  for (const Refused& refused : all) {
    Arguments a{
        view(scene), forward_camera(40, 30), {}, {.width = 40, .height = 30, .colour = {memory.data(), 480}}};
    const auto render = [&] { renderer.render_into(a.scene, a.camera, a.settings, a.frame); };
    CHECK_NOTHROW(render());
    refused.spoil(a);
    CHECK_THROWS_WITH_AS(render(), doctest::Contains(refused.why), std::invalid_argument);
  }
  scene.features.pop_back();
  CHECK_THROWS_WITH_AS(validate(scene), "scene: features has 29 elements, expected 30",
                       std::invalid_argument);
  scene.feature_channels = -1;
  CHECK_THROWS_WITH_AS(validate(scene), "scene: feature_channels is -1, expected 0 to 16777216",
                       std::invalid_argument);
}

SWIFTGS_CASE_ON("renderer: its memory is that of its stages and grows only with the frame",
                SWIFTGS_TEST_HOSTS) {
  Usual<B> renderer(std::move(backend));
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
  Usual<Watched> renderer;
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

TEST_CASE("limits: cameras beyond what float holds are refused") {
  const auto check = [](const char* expected, const auto& change) {
    Camera camera = forward_camera(40, 30);
    change(camera);
    if (expected)
      CHECK_THROWS_WITH_AS(validate(camera), expected, std::invalid_argument);
    else
      CHECK_NOTHROW(validate(camera));
  };
  check(nullptr, [](Camera& c) { c.fx = 1e-6, c.fy = 1e12, c.cx = -1e9, c.cy = 1e9; });
  for (const double focal : {0.0, -1.0, 9e-7, 1.1e12, 1e300, double(INFINITY)})
    check("camera: expected focal lengths of 1e-6 to 1e12 pixels", [&](Camera& c) { c.fy = focal; });
  for (const double point : {1.1e9, -1e300, double(INFINITY)})
    check("camera: expected a principal point at most 1e9 pixels from the corner",
          [&](Camera& c) { c.cx = point; });
  // Rows are orthonormal to 1e-3: a product of two of them is off by less.
  for (const double off : {9.9e-4, -9.9e-4, 1.01e-3, -1.01e-3, 1.0, double(NAN), double(INFINITY)}) {
    CAPTURE(off);
    const bool good = std::abs(off) < 1e-3;
    const char* const expected = good ? nullptr : "camera: expected a rotation with orthonormal rows";
    check(expected, [&](Camera& c) { c.rotation[0].y = off; });
    check(expected, [&](Camera& c) { c.rotation[2].z = std::sqrt(1 + off); });
  }
}

TEST_CASE_TEMPLATE("limits: harmonics are seen from the right direction at any depth", B,
                   SWIFTGS_TEST_HOSTS) {
  for (const double depth : {1e-12, 1.0, 1e20, 1e30}) {
    CAPTURE(depth);
    Scene scene = random_scene(1, 1, 1);
    scene.means[0] = vec3(float(0.3 * depth), float(-0.2 * depth), float(depth));
    scene.scales[0] = vec3(float(0.5 * depth)), scene.opacities[0] = 0.9f;
    scene.sh_rest.assign(9, 0.5f), scene.sh0[0] = vec3(1);
    RenderSettings settings;
    settings.conventions.near_plane = 0;
    settings.conventions.far_plane = INFINITY;
    Usual<B> renderer(test::make_backend<B>());
    const Frame frame = renderer.render(renderer.backend().upload(scene), forward_camera(32, 32), settings);
    const ReferenceFrame reference = render_reference(scene, forward_camera(32, 32), settings.conventions);
    CHECK(reference.alpha[16 * 32 + 16] > 0.5);
    CHECK(max_abs_difference(frame.colour, reference.colour) < 2e-6);
  }
}

}  // namespace swiftgs::test::renderer_test
