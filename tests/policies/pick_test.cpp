// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
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

using namespace swiftgs;
using namespace swiftgs::test;

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

SWIFTGS_CONTRACT("pick: sorts and conservative bounds change no bit") {
  const Scene scene = make_builtin_scene(5'000);
  const Camera camera = small_camera();
  Usual<B> renderer(std::move(backend));
  renderer.render(renderer.backend().upload(scene), camera);
  const std::vector<PickedPixel> expected = pick_all(renderer, camera);
  Usual<B, StandardSort, AxisSharedThreshold<FloatCholesky>, OpacityBox> other(make_backend<B>());
  other.render(other.backend().upload(scene), camera);
  CHECK(pick_all(other, camera) == expected);
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

SWIFTGS_CONTRACT("pick: a splat whose colour is not finite is not there") {
  Scene scene;
  append(scene, vec3(0, 0, 2), 1, 0.9f), append(scene, vec3(0, 0, 4), 1, 0.9f);
  scene.sh0[0] = vec3(3e38f), scene.sh_degree = 2;
  scene.sh_rest.assign(2 * 24, 0);
  std::fill_n(scene.sh_rest.begin(), 24, 3e38f);
  Usual<B> renderer(std::move(backend));
  const Camera camera = forward_camera(32, 32);
  const Frame frame = renderer.render(renderer.backend().upload(scene), camera, settings_of({true, true}));
  CHECK(renderer.pick(16, 16).gaussian == 1);
  CHECK(frame.depth[16 * 32 + 16] == doctest::Approx(4));
}

SWIFTGS_CONTRACT("pick: nothing is where no splat shows") {
  const Camera camera = small_camera();
  Usual<B> renderer(std::move(backend));
  renderer.render(renderer.backend().upload(Scene()), camera);
  CHECK(renderer.pick(camera.width - 1, camera.height - 1) == PickedPixel());
}

SWIFTGS_CONTRACT("pick: of equal weights the nearest Gaussian, and a median only below one half") {
  Camera camera = forward_camera(32, 32);
  camera.cx = camera.cy = 16.5;
  RenderSettings settings;
  settings.conventions.alpha_max = 1, settings.conventions.stop = 0,
  settings.conventions.stop_at_equal = false;
  // On the axis, so that alphas in the middle pixel are the opacities.
  const auto pick_of_two = [&](float first_depth, float first_opacity, float second_depth,
                               float second_opacity) {
    Scene scene;
    append(scene, vec3(0, 0, first_depth), 1, first_opacity);
    append(scene, vec3(0, 0, second_depth), 1, second_opacity);
    Usual<B> renderer(make_backend<B>());
    renderer.render(renderer.backend().upload(scene), camera, settings);
    return renderer.pick(16, 16);
  };
  CHECK(pick_of_two(2, 0.5f, 4, 1) == PickedPixel{0, 0.5f, 2, 1, 4});
  CHECK(pick_of_two(4, 1, 2, 0.5f) == PickedPixel{1, 0.5f, 2, 0, 4});
  CHECK(pick_of_two(4, 0.25f, 2, 0.25f) == PickedPixel{1, 0.25f, 2});
  CHECK(pick_of_two(4, 0.75f, 2, 0.25f) == PickedPixel{0, 0.5625f, 4, 0, 4});
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
