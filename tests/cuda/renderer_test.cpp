// SPDX-License-Identifier: Apache-2.0

// Whole frames from the device: against the reference in double, and pixel by pixel against the cpu backend.
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/edit.hpp>
#include <swiftgs/metrics.hpp>
#include <swiftgs/reference.hpp>

#include "cuda/drawings.hpp"
#include "policies/cameras.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

bool has(std::string_view name, std::string_view word) { return name.find(word) != std::string_view::npos; }

Frame render(const RendererEntry& entry, const std::shared_ptr<const Scene>& scene, const Camera& camera,
             const RenderSettings& settings) {
  const auto renderer = entry.make();
  renderer->set_scene(scene);
  Frame frame, again;
  renderer->render(camera, settings, frame);
  renderer->render(camera, settings, again);
  CHECK(same_bits(again.colour, frame.colour));
  CHECK(same_bits(again.alpha, frame.alpha));
  CHECK(same_bits(again.depth, frame.depth));
  return frame;
}

/// Renders with every renderer of the device and checks all that holds between them, the cpu backend's and
/// the reference. One frame of each group that has the same bits is compared with both.
void check_all(const Scene& whole, const Camera& camera, Conventions conventions) {
  const auto scene = std::make_shared<const Scene>(whole);
  RenderSettings settings;
  settings.conventions = conventions, settings.background = vec3(0.2f, 0.3f, 0.4f);
  settings.outputs = {true, true};
  const auto reference_of = [&](Conventions::Footprint footprint) {
    conventions.footprint = footprint;
    return render_reference(whole, camera, conventions, dvec3(settings.background));
  };
  const ReferenceFrame lossless = reference_of(Conventions::Footprint::alpha);
  const ReferenceFrame cut = reference_of(Conventions::Footprint::three_sigma_square);

  std::map<std::string, Frame> first_of;
  for (const RendererEntry& entry : renderers()) {
    if (!has(entry.name, "cuda/")) continue;
    CAPTURE(entry.name);
    const Frame frame = render(entry, scene, camera, settings);
    const std::string name(entry.name);
    const std::size_t raster = name.find('/', name.find('/') + 1), bounds = name.rfind('/');
    const bool square = has(name, "three-sigma-square"), half = has(name, "half-split");
    const auto [first, is_first] =
        first_of.try_emplace(name.substr(raster, bounds - raster) + (square ? "/square" : ""), frame);
    CHECK(same_bits(first->second.colour, frame.colour));
    CHECK(same_bits(first->second.alpha, frame.alpha));
    CHECK(same_bits(first->second.depth, frame.depth));
    if (!is_first) continue;

    const ReferenceFrame& reference = square ? cut : lossless;
    // Split terms of floats err more where a part is far from the mean of a needle.
    const double least_db = half ? 40 : has(name, "float-split") ? 105 : 120;
    CHECK(psnr(frame.colour, reference.colour) >= least_db);
    CHECK(psnr(frame.alpha, reference.alpha) >= least_db);
    if (!half) CHECK(max_abs_difference(frame.colour, reference.colour) <= 1.0 / 255);
    if (!half) CHECK(max_abs_difference(frame.alpha, reference.alpha) <= 1.0 / 255);

    const auto cpu = make_renderer("cpu" + name.substr(4));
    cpu->set_scene(scene);
    Frame expected;
    cpu->render(camera, settings, expected);
    const Difference colour = difference(frame.colour, expected.colour, 5e-5);
    CHECK(colour.largest < 0.05);  // colours reach 3
    CHECK(colour.part_above <= (half ? 0.1 : 0.002));
    CHECK(difference(frame.alpha, expected.alpha, 5e-5).part_above <= (half ? 0.1 : 0.002));
  }
  CHECK(first_of.size() == 7 * 2);
}

using Usual = Renderer<Cuda, EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse>;

}  // namespace

TEST_CASE("cuda renderer: all draw the reference's image for each SH degree") {
  if (without_device()) return;
  for (const int degree : {0, 1, 2, 3}) {
    CAPTURE(degree);
    check_all(random_scene(400, degree, std::uint64_t(degree) + 1), forward_camera(131, 77),
              Conventions::gsplat());
  }
}

TEST_CASE("cuda renderer: all draw the reference's image with the inria preset") {
  if (without_device()) return;
  check_all(random_scene(600, 3, 5), forward_camera(97, 61), Conventions::inria());
}

TEST_CASE("cuda renderer: all draw the reference's image in the antialiased mode") {
  if (without_device()) return;
  Scene scene = random_scene(600, 1, 6);
  for (vec3& scale : scene.scales) scale *= 0.3f;  // a pixel or less, where it matters
  for (Conventions conventions : {Conventions::gsplat(), Conventions::inria()}) {
    conventions.antialiased = true;
    check_all(scene, forward_camera(80, 60), conventions);
  }
}

TEST_CASE("cuda renderer: all draw the reference's image with a principal point outside the image") {
  if (without_device()) return;
  Camera camera = forward_camera(64, 48);
  camera.cx = -20, camera.cy = 70;
  check_all(random_scene(400, 2, 7), camera, Conventions::gsplat());
}

TEST_CASE("cuda renderer: all draw the reference's image of the built-in scene") {
  if (without_device()) return;
  check_all(make_builtin_scene(8000), builtin_camera(192, 108), Conventions::gsplat());
}

TEST_CASE("cuda renderer: every combination draws several views as it draws each alone") {
  if (without_device()) return;
  const auto scene = std::make_shared<const Scene>(make_builtin_scene(8000));
  const std::vector<Camera> cameras = builtin_cameras(5, 192, 108);
  RenderSettings settings;
  settings.outputs = {true, true}, settings.background = vec3(0.2f, 0.3f, 0.4f);
  for (const RendererEntry& entry : renderers()) {
    if (!has(entry.name, "cuda/")) continue;
    CAPTURE(entry.name);
    check_cameras(*entry.make(), scene, {cameras.data(), cameras.size()}, settings);
  }
}

TEST_CASE("cuda renderer: several views of a scene in chunks are drawn as each alone") {
  if (without_device()) return;
  const Scene builtin = make_builtin_scene(100'000);
  const auto scene = std::make_shared<const Scene>(order_spatially(builtin));
  const std::vector<Camera> cameras = builtin_cameras(5, 192, 108);
  check_cameras(*make_renderer(Usual::name), scene, {cameras.data(), cameras.size()}, {});
}

TEST_CASE("cuda renderer: counts what it did and says how long it took") {
  if (without_device()) return;
  Usual renderer;
  Renderer<Serial, EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse> serial;
  const Scene scene = random_scene(3000, 0, 2);
  RenderSettings settings;
  settings.count = settings.time = true;
  renderer.render(renderer.backend().upload(scene), forward_camera(180, 160), settings);
  serial.render(serial.backend().upload(scene), forward_camera(180, 160), settings);
  const Statistics statistics = renderer.statistics(), expected = serial.statistics();
  CHECK(statistics.gaussians == 3000);
  CHECK(std::abs(double(statistics.visible) - double(expected.visible)) <= 1);
  CHECK(double(statistics.instances) == doctest::Approx(double(expected.instances)).epsilon(1e-3));
  CHECK(double(statistics.raster.contributing_pairs) ==
        doctest::Approx(double(expected.raster.contributing_pairs)).epsilon(1e-3));
  CHECK(statistics.raster.instances_visited <= statistics.instances);
  const StageTimes times = renderer.times();
  CHECK(times.project > 0);
  CHECK(times.sort > 0);
  CHECK(times.raster > 0);
  CHECK(times.total == doctest::Approx(times.project + times.sort + times.raster).epsilon(0.05));
}

TEST_CASE("cuda renderer: a large image with few splats has the same bits by coarser tiles") {
  if (without_device()) return;
  Usual renderer;
  const auto scene = renderer.backend().upload(random_scene(4000, 0, 3));
  const auto tiles_of = [&](auto& by, const Camera& camera, const auto& of) {
    const Frame frame = by.render(of, camera);
    CHECK(by.lists().tiles == by.tiles().size());
    return std::pair{frame, by.tiles()};
  };
  const Camera large = forward_camera(1600, 1000);
  const auto [first, fine] = tiles_of(renderer, large, scene);
  const auto [second, coarse] = tiles_of(renderer, large, scene);
  CHECK(fine == FrameTiles{100, 63, 16});
  CHECK(coarse == FrameTiles{50, 32, 32});
  CHECK(same_bits(first.colour, second.colour));

  // Not after a frame of another size, nor in a small image, nor where bounds cut splats at tiles.
  const Camera small = forward_camera(320, 200);
  for (int i = 0; i < 2; ++i) CHECK(tiles_of(renderer, small, scene).second == FrameTiles{20, 13, 16});
  CHECK(tiles_of(renderer, large, scene).second == fine);
  Renderer<Cuda, EarlySort, AxisSharedThreshold<FloatCholesky>, ThreeSigmaSquare> cutting;
  const auto again = cutting.backend().upload(random_scene(4000, 0, 3));
  for (int i = 0; i < 2; ++i) CHECK(tiles_of(cutting, large, again).second == fine);

  // Rasterizers that evaluate each listed splat at every pixel keep fine tiles.
  const auto stays_fine = [&]<class Raster>(Raster) {
    Renderer<Cuda, EarlySort, Raster, Ellipse> other;
    const auto uploaded = other.backend().upload(random_scene(4000, 0, 3));
    for (int i = 0; i < 2; ++i) CHECK(tiles_of(other, large, uploaded).second == FrameTiles{100, 63, 16});
  };
  stays_fine(PerPixel()), stays_fine(AxisShared<HalfSplit>()), stays_fine(AxisSharedThreshold<HalfSplit>());
}

TEST_CASE("cuda renderer: a scene in the memory of one that is gone is not sorted by what was learnt of it") {
  if (without_device()) return;
  Renderer<Cuda, AdaptiveSort, AxisSharedThreshold<FloatCholesky>, Ellipse> renderer{Cuda(), AdaptiveSort(1)};
  const Camera camera = forward_camera(200, 150);
  const DeviceArrays memory(random_scene(50'000, 0, 1));
  SceneView scene = memory.view();
  scene.identity = new_scene_identity();
  for (int i = 0; i < 50 && !renderer.sort().calibration(); ++i) {
    renderer.render_resident(scene, camera, {});
    renderer.backend().wait();
  }
  REQUIRE(renderer.sort().calibration());
  scene.identity = new_scene_identity();
  renderer.render_resident(scene, camera, {});
  CHECK_FALSE(renderer.sort().calibration());
}

TEST_CASE("cuda renderer: one renderer draws scenes and sizes in any order as new ones do") {
  if (without_device()) return;
  Usual renderer;
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
    Usual fresh;
    CHECK(same_bits(renderer.render(scene, camera).colour, fresh.render(scene, camera).colour));
  }
}
