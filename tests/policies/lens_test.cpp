// SPDX-License-Identifier: Apache-2.0

// Frames through lenses, on every backend.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <stdexcept>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/edit/all.hpp>
#include <swiftgs/metrics.hpp>

#include "policies/backends.hpp"
#include "policies/image_parts.hpp"
#include "policies/lenses.hpp"
#include "policies/random_splats.hpp"
#include "policies/rasterizers.hpp"
#include "policies/views.hpp"

namespace swiftgs::test::lens_test {

namespace {

constexpr double turn = 2 * std::numbers::pi;

Scene test_scene() { return order_spatially(make_builtin_scene(6000)); }

RenderSettings all_outputs() { return settings_of({true, true}, vec3(0.2f, 0.3f, 0.4f)); }

std::vector<AskedView> views_of_lenses() {
  std::vector<AskedView> views;
  for (const Camera& camera : cameras_of_lenses())
    views.push_back({camera, Conventions::gsplat(), vec3(0.2f, 0.3f, 0.4f)});
  return views;
}

/// `camera` turned about the vertical. @units{radians}
Camera turned(Camera camera, double angle) {
  const dmat3 about_y(dvec3(std::cos(angle), 0, -std::sin(angle)), dvec3(0, 1, 0),
                      dvec3(std::sin(angle), 0, std::cos(angle)));
  camera.rotation = about_y * camera.rotation, camera.translation = about_y * camera.translation;
  return camera;
}

}  // namespace

SWIFTGS_CONTRACT("lens: views of one frame and parts of an image have the bits of single frames") {
  Usual<B> together(std::move(backend)), alone(test::make_backend<B>());
  const auto scene = together.backend().upload(test_scene());
  const std::vector<AskedView> views = views_of_lenses();
  check_views(together, alone, scene.view(), views);
  for (const AskedView& asked : views) {
    CAPTURE(name_of(asked.camera.lens.model));
    check_parts(together, scene.view(), asked, cut(asked.width, asked.height, {0}, {0, 32}));
  }
}

SWIFTGS_CONTRACT("lens: chunks hide nothing that a lens shows") {
  Usual<B> renderer(std::move(backend));
  const auto scene = renderer.backend().upload(test_scene());
  SceneView without_chunks = scene.view();
  REQUIRE_FALSE(without_chunks.chunks.empty());
  without_chunks.chunks = {};
  std::vector<Camera> cameras = cameras_of_lenses();
  for (const double angle : {0.3, 2.0, 4.5})  // panoramas that look elsewhere
    cameras.push_back(turned(cameras[5], angle));
  for (const Camera& camera : cameras) {
    CAPTURE(name_of(camera.lens.model));
    renderer.render_resident(scene.view(), camera, all_outputs());
    const std::size_t visible = renderer.statistics().visible;
    renderer.render_resident(without_chunks, camera, all_outputs());
    CHECK(renderer.statistics().visible == visible);
  }
}

SWIFTGS_CASE_ON("lens: recorded frames draw what frames draw", SWIFTGS_TEST_HOSTS) {
  Usual<B> renderer(std::move(backend));
  const auto scene = renderer.backend().upload(test_scene());
  Report<B> report;
  for (const AskedView& asked : views_of_lenses()) {
    CAPTURE(name_of(asked.camera.lens.model));
    PlacedViews recorded(renderer.backend(), {asked});
    renderer.reserve(scene.view(), recorded.span());
    renderer.record(scene.view(), report.data());
    CHECK(differing(recorded.finish(renderer.backend()), draw_together(renderer, scene.view(), {asked})) ==
          0);
  }
}

SWIFTGS_CASE_ON(
    "lens: columns of a panorama have the bits of the whole, bottom up, over an image and behind depths",
    SWIFTGS_TEST_HOSTS) {
  Usual<B> renderer(std::move(backend));
  const auto scene = renderer.backend().upload(test_scene());
  AskedView down{cameras_of_lenses(256, 128)[5]};
  down.over = down.occluder = true;
  AskedView up = down;
  up.upward = 1;
  for (const AskedView& asked : {down, up})
    check_parts(renderer, scene.view(), asked, cut(256, 128, {0, 48, 64}, {0}));
  PlanesMemory drawn = draw_together(renderer, scene.view(), {up})[0];
  drawn.turn(0);
  CHECK((drawn.bytes == draw_together(renderer, scene.view(), {down})[0].bytes));
}

SWIFTGS_CASE_ON("lens: tiles that are no divisor of a panorama's parts are refused", SWIFTGS_TEST_HOSTS) {
  Usual<B> renderer(std::move(backend));
  const auto scene = renderer.backend().upload(test_scene());
  const Camera camera = cameras_of_lenses(256, 128)[5];
  Frame frame;
  View view = make_view(camera, Conventions::gsplat(), prepare(frame, 256, 128, {}));
  view.grid = TileGrid::covering(256, 128, 64);
  CHECK_THROWS_WITH_AS(renderer.render_into(scene.view(), Span<const View>{&view, 1}),
                       doctest::Contains("the side is 64, expected a divisor of the 32 columns"),
                       std::invalid_argument);
}

SWIFTGS_CONTRACT("lens: a panorama that turns shows the same, moved across its seam") {
  Usual<B> renderer(std::move(backend));
  const auto scene = renderer.backend().upload(test_scene());
  const Camera camera = cameras_of_lenses(256, 128)[5];
  const Frame before = renderer.render(scene, camera, all_outputs());
  constexpr int moved = 128;  // a multiple of the parts in which panoramas are drawn
  const Frame after = renderer.render(scene, turned(camera, turn * moved / 256), all_outputs());
  std::vector<float> moved_back = after.colour;
  for (auto row = moved_back.begin(); row != moved_back.end(); row += 3 * 256)
    std::rotate(row, row + 3 * moved, row + 3 * 256);
  CHECK(psnr(moved_back, before.colour) >= 90);
}

}  // namespace swiftgs::test::lens_test
