// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/cpu.hpp>
#include <swiftgs/metrics.hpp>
#include <swiftgs/pages/page_pool.hpp>
#include <swiftgs/swiftgs.hpp>

#include "pages/pools.hpp"

namespace swiftgs::test::estimates {
namespace {

/// Of a size of which an estimate leaves out three pixels in four.
constexpr int columns = 512, rows = 400;

View view_of(const Camera& camera, const Conventions& conventions) {
  return make_view(camera, conventions, {.width = columns, .height = rows});
}

TEST_CASE("pages: estimates are near what is measured whatever memory they have") {
  Scene scene = ordered_scene(20000);
  for (vec3& scale : scene.scales) scale = glm::min(scale, vec3(0.03f));  // so that parts need few pages
  const PagedScene pages = open(TestSource::of(scene));
  Renderer<Cpu> renderer;
  const auto whole = renderer.backend().upload(scene);
  for (const bool antialiased : {true, false}) {
    RenderSettings settings;
    settings.conventions.antialiased = antialiased, settings.background = vec3(0.5f);
    PagePool<Cpu> roomy(renderer.backend(), pages, {.estimate = 100'000'000}),
        tight(renderer.backend(), pages, {.estimate = 7'000'000});  // for parts of a view
    for (const Camera& camera : builtin_cameras(3, columns, rows)) {
      View view = view_of(camera, settings.conventions);
      view.background = settings.background;
      const Frame expected = renderer.render(whole, camera, settings);
      for (const double pixels : {8.0, 2.0}) {
        Cut cut = roomy.cut({&view, 1}, {.pixels = pixels});
        roomy.wait(cut);
        const double db = psnr(renderer.render(cut.scenes(), camera, settings).colour, expected.colour);
        INFO("pixels ", pixels, ", measured ", db, ", estimated ", cut.estimated_db());
        CHECK(std::abs(cut.estimated_db() - db) < 1);
        Cut same = tight.cut({&view, 1}, {.pixels = pixels});
        tight.wait(same);
        CHECK(same.estimated_db() == doctest::Approx(cut.estimated_db()));
      }
    }
  }
}

TEST_CASE("pages: an estimate of another cut than before follows what is placed") {
  const Scene scene = ordered_scene(5000);
  const PagedScene pages = open(TestSource::of(scene));
  Serial backend;
  PagePool<Serial> pool(backend, pages, {.estimate = 100'000'000});
  const View view = view_of(builtin_camera(columns, rows), {});
  const auto estimated = [&](double pixels) {
    Cut cut = pool.cut({&view, 1}, {.pixels = pixels});
    pool.wait(cut);
    return cut.estimated_db();
  };
  CHECK(estimated(0) == std::numeric_limits<double>::infinity());
  const double near = estimated(16);
  CHECK(estimated(1e6) < near);  // of the root, whose error is far less
  CHECK(near < 60);
  pool.place({{pages, {.translation = dvec3(0, 0, 20)}}});
  const double far = estimated(16);
  CHECK(std::abs(far - near) > 0.1);
  pool.place({{pages}});
  CHECK(estimated(16) == near);
}

TEST_CASE("pages: nothing is estimated without enough memory and where pages cannot be read") {
  const auto source = TestSource::of(ordered_scene(5000));
  const PagedScene pages = open(source);
  Serial backend;
  PagePool<Serial> none(backend, pages), little(backend, pages, {.estimate = 200'000}),
      pool(backend, pages, {.estimate = 100'000'000});
  const View view = view_of(builtin_camera(columns, rows), {});
  CHECK(std::isnan(none.cut({&view, 1}).estimated_db()));
  Cut coarse = little.cut({&view, 1}, {.pixels = 16});
  little.wait(coarse);
  CHECK(std::isnan(coarse.estimated_db()));
  source->before_read = [] { throw std::runtime_error("no disk"); };
  Cut cut = pool.cut({&view, 1}, {.pixels = 16});
  pool.wait(cut);
  CHECK(std::isnan(cut.estimated_db()));
}

}  // namespace
}  // namespace swiftgs::test::estimates
