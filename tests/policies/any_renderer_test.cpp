// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <stdexcept>

#include <doctest/doctest.h>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/builtin_scene.hpp>

using namespace swiftgs;

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
  const std::size_t instances = renderer->statistics().instances;
  RenderSettings counting;
  counting.count = true;
  renderer->render_resident(small_camera(), counting);
  CHECK(renderer->times().total > 0);
  CHECK(renderer->statistics().instances == instances);
  CHECK(renderer->statistics().raster.contributing_pairs > 0);
  CHECK_FALSE(renderer->device_memory().has_value());
}
