// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <stdexcept>

#include <doctest/doctest.h>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/swiftgs.hpp>

#include "policies/cameras.hpp"
#include "policies/random_splats.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

constexpr const char* plain = "serial/early/per-pixel/ellipse";
constexpr const char* other_sort = "serial/standard/per-pixel/ellipse";

std::shared_ptr<const Scene> small_scene() { return std::make_shared<const Scene>(make_builtin_scene(500)); }
Camera small_camera() { return scaled(builtin_camera(), 0.05); }

}  // namespace

TEST_CASE("any renderer: a shared scene is drawn as an uploaded one") {
  const std::unique_ptr<AnyRenderer> first = make_renderer(plain), second = make_renderer(other_sort);
  CHECK_FALSE(second->share_scene(*first));
  CHECK_THROWS_AS(second->render_resident(small_camera(), {}), std::logic_error);
  first->set_scene(small_scene());
  REQUIRE(second->share_scene(*first));
  Frame expected, shared;
  first->render(small_camera(), {}, expected);
  second->render(small_camera(), {}, shared);
  CHECK(shared.colour == expected.colour);
}

TEST_CASE("any renderer: a scene is not shared across backends") {
  const std::unique_ptr<AnyRenderer> serial = make_renderer(plain);
  serial->set_scene(small_scene());
  for (const RendererEntry& entry : renderers()) {
    if (!entry.usable || entry.name.starts_with("serial/")) continue;
    CHECK_FALSE(entry.make()->share_scene(*serial));
    break;
  }
}

TEST_CASE("any renderer: a resident frame is finished and counted as any other") {
  const std::unique_ptr<AnyRenderer> renderer = make_renderer(plain);
  renderer->set_scene(small_scene());
  Frame frame;
  renderer->render(small_camera(), {}, frame);
  CHECK(std::isnan(renderer->times().total));
  const std::size_t instances = renderer->statistics().instances;
  RenderSettings counting;
  counting.count = counting.time = true;
  renderer->render_resident(small_camera(), counting);
  CHECK(renderer->times().total > 0);
  CHECK(renderer->statistics().instances == instances);
  CHECK(renderer->statistics().raster.contributing_pairs > 0);
  CHECK_FALSE(renderer->device_memory().has_value());
}

TEST_CASE("any renderer: every combination of the host draws several views as it draws each alone") {
  const auto scene = small_scene();
  Camera other = small_camera(), third = scaled(builtin_camera(), 0.03);
  other.translation = dvec3(0.3, -0.1, 0.2), third.height -= 3;
  const Camera cameras[] = {small_camera(), other, third, other};
  RenderSettings settings;
  settings.outputs = {true, true}, settings.background = vec3(0.2f, 0.3f, 0.4f);
  std::size_t tried = 0;
  for (const RendererEntry& entry : renderers()) {
    if (!entry.name.starts_with("serial/") && !entry.name.starts_with("cpu/")) continue;
    CAPTURE(entry.name);
    check_cameras(*entry.make(), scene, {cameras, std::size(cameras)}, settings), ++tried;
  }
  CHECK(tried == 2 * AllSorts::size * AllRasters::size * AllBounds::size);
}

TEST_CASE("any renderer: measurements reach an adaptive sort and change nothing of another") {
  const Camera camera = small_camera();
  const SortCalibration saved{500, camera.width, camera.height, 1, 2};
  for (const char* name : {"serial/adaptive/per-pixel/ellipse", plain}) {
    const std::unique_ptr<AnyRenderer> renderer = make_renderer(name), without = make_renderer(name);
    renderer->set_scene(small_scene()), without->set_scene(small_scene());
    renderer->use_calibrations({saved});
    CHECK_FALSE(renderer->calibration());
    Frame frame, expected;
    renderer->render(camera, {}, frame), without->render(camera, {}, expected);
    CHECK(frame.colour == expected.colour);
    CHECK_FALSE(without->calibration());
    CHECK(renderer->calibration().has_value() == (name != plain));
    if (renderer->calibration()) CHECK(renderer->calibration()->early_ms == 2);
  }
}

TEST_CASE("any renderer: every backend that runs here says on what") {
  for (const RendererEntry& entry : renderers()) {
    if (!entry.usable || entry.name.find("/early/per-pixel/ellipse") == std::string_view::npos) continue;
    const std::string device = entry.make()->device_name();
    CAPTURE(device);
    CHECK(device.size() > 3);
    CHECK(device.find('\n') == std::string::npos);
    CHECK((device.find("thread") != std::string::npos) == entry.name.starts_with("cpu/"));
  }
}

TEST_CASE("any renderer: all that a view asks for, on the caller's threads") {
  const auto scene = std::make_shared<const Scene>(random_scene(2000, 1, 7));
  const Camera camera = forward_camera(90, 60);
  for (const RendererEntry& entry : renderers()) {
    if (!entry.usable || entry.name.starts_with("cuda/") || !entry.name.ends_with("/ellipse")) continue;
    CAPTURE(entry.name);
    const auto renderer = entry.make({.threads = 1}), other = entry.make();
    renderer->set_scene(scene), other->set_scene(scene);
    Frame expected;
    RenderSettings settings;
    settings.outputs = {true, true};
    settings.background = vec3(0.1f, 0.2f, 0.3f);
    other->render(camera, settings, expected);

    // Rows that go up in memory, into a larger image.
    std::vector<float> colour(3 * 100 * 60, -1.0f), alpha(90 * 60), depth(90 * 60);
    const std::ptrdiff_t pitch = 3 * 100 * std::ptrdiff_t(sizeof(float));
    const FrameView frame{.width = 90,
                          .height = 60,
                          .colour = {colour.data() + 3 * 100 * 59, -pitch},
                          .alpha = {alpha.data(), 90 * std::ptrdiff_t(sizeof(float))},
                          .depth = {depth.data(), 90 * std::ptrdiff_t(sizeof(float))}};
    const View view = make_view(camera, settings.conventions, frame, settings.background);
    renderer->render_into({&view, 1}, {.count = true});
    CHECK(renderer->statistics().raster.contributing_pairs > 0);
    const auto same = [&] {
      bool equal = alpha == expected.alpha && depth == expected.depth;
      for (std::size_t y = 0; y < 60; ++y)
        equal = equal && std::equal(&expected.colour[3 * 90 * y], &expected.colour[3 * 90 * y] + 3 * 90,
                                    &colour[3 * 100 * (59 - y)]);
      return equal;
    };
    CHECK(same());
    for (std::vector<float>* plane : {&colour, &alpha, &depth})
      std::fill(plane->begin(), plane->end(), -1.0f);
    renderer->reserve({&view, 1});
    CHECK(alpha[0] == -1);
    renderer->set_views({&view, 1});
    FrameReport report;
    renderer->record(&report);
    renderer->wait();
    CHECK(report.overflowed == 0);
    CHECK(report.visible == renderer->statistics().visible);
    CHECK(same());
  }
}
