// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>

#include "policies/planes.hpp"
#include "policies/rasterizers.hpp"
#include "policies/views.hpp"

namespace swiftgs::test::pick_test {

namespace {

Camera small_camera() { return scaled(builtin_camera(), 0.1); }

/// Compares with the reference, close decisions excluded.
void check_picks(const std::vector<PickedPixel>& picks, const Scene& scene, const Camera& camera,
                 const Conventions& conventions = {}) {
  const ReferencePlanes expected = render_reference_planes(scene, camera, conventions);
  REQUIRE(picks.size() == expected.pixels());
  std::size_t wrong = 0, judged = 0;
  const auto differ = [](double a, double b) { return std::abs(a - b) > 1e-5 * std::abs(b); };
  for (std::size_t i = 0; i < picks.size(); ++i) {
    const PickedPixel& found = picks[i];
    const double weight = expected.weight[i];
    if (weight - expected.next_weight[i] > 1e-3 * weight || weight == 0) {
      ++judged;
      wrong += found.gaussian != expected.id[i] || differ(found.depth, expected.depth_of_id[i]) ||
               std::abs(found.weight - weight) > 1e-5;
    }
    if (expected.median_margin[i] > 1e-4)
      wrong += found.median != expected.median_id[i] || differ(found.median_depth, expected.median_depth[i]);
  }
  CHECK(wrong == 0);
  CHECK(judged > picks.size() / 2);
}

}  // namespace

SWIFTGS_CONTRACT("pick: pixels show the Gaussians that the reference finds") {
  const Scene scene = make_builtin_scene(20'000);
  const Camera camera = small_camera();
  Usual<B> renderer(std::move(backend));
  renderer.render(renderer.backend().upload(scene), camera);
  check_picks(pick_all(renderer, camera), scene, camera);
}

SWIFTGS_CONTRACT("pick: each view of a frame has its own pixels, through its own lens") {
  const Scene scene = make_builtin_scene(3'000);
  std::vector<Camera> cameras(3, small_camera());
  cameras[1].lens.model = LensModel::fisheye;
  cameras[2].lens.model = LensModel::equirectangular;
  cameras[2].width = 2 * cameras[2].height;
  cameras[2].fx = cameras[2].width / 6.283185307179586, cameras[2].fy = cameras[2].height / 3.141592653589793;
  cameras[2].cx = 0.5 * cameras[2].width, cameras[2].cy = 0.5 * cameras[2].height;
  Usual<B> renderer(std::move(backend));
  std::vector<Frame> frames(cameras.size());
  renderer.render(renderer.backend().upload(scene), span_of(cameras), {}, span_of(frames));
  for (std::size_t view = 0; view < cameras.size(); ++view) {
    CAPTURE(view);
    check_picks(pick_all(renderer, cameras[view], view), scene, cameras[view]);
  }
  CHECK_THROWS_WITH_AS(renderer.pick(0, 0, 3), "pick: the view is number 3, expected less than 3",
                       std::invalid_argument);
}

SWIFTGS_CONTRACT("pick: strips of an image have its pixels, with coarse tiles too") {
  // Few splats in many pixels: a device draws the second frame with coarser tiles.
  const Camera camera = builtin_camera(2048, 1024);
  constexpr int top = 512;
  Usual<B> renderer(std::move(backend));
  const auto scene = renderer.backend().upload(make_builtin_scene(2'000));
  const auto middle = [&](int y) { return renderer.pick({.x = 1000, .y = y, .width = 60, .height = 60}); };
  renderer.render(scene, camera);
  const std::vector<PickedPixel> expected = middle(top);
  renderer.render(scene, camera);
  CHECK(middle(top) == expected);

  PlanesOn<B> planes(renderer.backend(), camera.width, camera.height - top, {});
  const View strip = make_view(camera, {}, planes.view(), vec3(0), {0, top});
  renderer.render_into(scene.view(), {&strip, 1});
  CHECK(middle(0) == expected);

  Usual<B> moved = std::move(renderer);
  CHECK(moved.pick({.x = 1000, .y = 0, .width = 60, .height = 60}) == expected);
}

// Binary fractions, so that all arithmetic is exact. The planes of a frame hold the same.
SWIFTGS_CONTRACT(
    "pick: the largest weight and of equal ones the nearest, and the median only below one half") {
  struct Row {
    std::vector<Ball> balls;
    PickedPixel expected;
    float stop = 0;
  };
  Usual<B> renderer(std::move(backend));
  for (const Row& row :
       {Row{{}, {}},
        {{{2, 0.5f}}, {0, 0.5f, 2}},
        {{{2, 0.5f}, {4, 1}}, {0, 0.5f, 2, 1, 4}},
        {{{4, 1}, {2, 0.5f}}, {1, 0.5f, 2, 0, 4}},
        {{{4, 0.25f}, {2, 0.25f}}, {1, 0.25f, 2}},
        {{{4, 0.75f}, {2, 0.25f}}, {0, 0.5625f, 4, 0, 4}},
        {{{2, 0.25f}, {3, 0.5f}, {4, 1}}, {1, 0.375f, 3, 1, 3}},  // the third takes all that is left
        {{{2, 0.25f}, {3, 0.375f}, {4, 1}}, {2, 0.46875f, 4, 1, 3}},
        {{{4, 0.5f}, {2, 0.25f}, {3, 0.25f}, {5, 0.5f}}, {0, 0.28125f, 4, 0, 4}},
        {{{2, 0.5f}, {3, 0.5f}}, {0, 0.5f, 2, 1, 3}, 0.25f},
        {{{2, 0.5f}, {3, 0.5f}}, {0, 0.5f, 2}, 0.375f}}) {  // the second would end the pixel
    CAPTURE(row.balls.size());
    Conventions conventions = exact_conventions();
    conventions.stop = row.stop;
    const Frame frame = renderer.render(renderer.backend().upload(balls(row.balls)), middle_camera(),
                                        settings_of_all(0, conventions));
    CHECK(renderer.pick(16, 16) == row.expected);
    CHECK(frame.id[middle_pixel] == row.expected.gaussian);
    CHECK(frame.median_id[middle_pixel] == row.expected.median);
    CHECK(frame.median_depth[middle_pixel] == row.expected.median_depth);
  }
}

SWIFTGS_CONTRACT("pick: invalid rectangles and views are refused, and so is a pick without a frame") {
  const Camera camera = small_camera();
  Usual<B> renderer(std::move(backend));
  CHECK_THROWS_WITH_AS(renderer.pick(0, 0), "pick: expected a frame before", std::logic_error);
  const auto scene = renderer.backend().upload(make_builtin_scene(300));
  renderer.render(scene, camera);
  const auto refused = [&](const PickRectangle& rectangle, const char* why) {
    CHECK_THROWS_WITH_AS(renderer.pick(rectangle), doctest::Contains(why), std::invalid_argument);
  };
  refused({.x = camera.width}, "pick: the rectangle has pixels 128 to 128 along x, ");
  refused({.y = -1}, "pick: the rectangle has pixels -1 to -1 along y, ");
  refused({.width = 65}, "pick: the rectangle has 65 pixels along x, expected 1 to 64");
  refused({.height = 0}, "pick: the rectangle has 0 pixels along y, expected 1 to 64");
  refused({.x = std::numeric_limits<int>::max()}, "2147483647 along x, ");
  renderer.trim();
  CHECK_THROWS_AS(renderer.pick(0, 0), std::logic_error);
}

SWIFTGS_CONTRACT("pick: a recorded frame is picked in, and one above its capacity shows nothing") {
  const Scene scene = make_builtin_scene(3'000);
  const Camera camera = small_camera();
  Usual<B> renderer(std::move(backend));
  const auto on = renderer.backend().upload(scene);
  renderer.render(on, camera);
  const std::vector<PickedPixel> expected = pick_all(renderer, camera);
  const FrameView frame = renderer.render_resident(on.view(), camera, {});
  const View view = make_view(camera, {}, frame);
  Report<B> report;
  renderer.reserve(on.view(), {&view, 1});
  CHECK_THROWS_AS(renderer.pick(0, 0), std::logic_error);
  renderer.record(on.view(), report.data());
  CHECK(pick_all(renderer, camera) == expected);
  renderer.reserve(on.view(), {&view, 1}, {100, 100});
  renderer.record(on.view(), report.data());
  if constexpr (B::reaches_host_memory)
    CHECK_THROWS_AS(renderer.pick(camera.width / 2, camera.height / 2), std::logic_error);
  else
    CHECK(renderer.pick(camera.width / 2, camera.height / 2) == PickedPixel());
}

}  // namespace swiftgs::test::pick_test
