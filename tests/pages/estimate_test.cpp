// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <thread>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/cpu.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/metrics.hpp>
#include <swiftgs/pages/page_pool.hpp>
#include <swiftgs/swiftgs.hpp>

#include "pages/pools.hpp"

namespace swiftgs::test::estimates {
namespace {

/// An image so large that an estimate draws one pixel in four.
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

/// The estimate of a complete cut.
double estimate_of(PagePool<Serial>& pool, const std::vector<View>& views, const CutGoal& goal) {
  Cut cut = pool.cut(all_of(views), goal);
  pool.wait(cut);
  return cut.estimated_db();
}

/// Checks the estimate of a complete cut beside the distance of all pixels of `views` from the scene.
void check_near(const Scene& scene, const std::vector<View>& views, const CutGoal& goal,
                std::size_t bytes = 100'000'000) {
  Renderer<Cpu> renderer;
  const auto whole = renderer.backend().upload(scene);
  PagePool<Cpu> pool(renderer.backend(), open(TestSource::of(scene)),
                     {.bytes = bytes, .ahead = 0, .estimate = 100'000'000});
  Cut cut = pool.cut(all_of(views), goal);
  pool.wait(cut);
  std::vector<float> found, expected;
  for (View view : views) {
    Frame frame;
    view.frame = prepare(frame, columns, rows, {});
    renderer.render_into(cut.scenes(), {&view, 1});
    found.insert(found.end(), frame.colour.begin(), frame.colour.end());
    renderer.render_into(whole, {&view, 1});
    expected.insert(expected.end(), frame.colour.begin(), frame.colour.end());
  }
  const double db = psnr(found, expected);
  INFO("measured ", db, ", estimated ", cut.estimated_db(), ", pixels ", cut.pixels());
  CHECK(std::abs(cut.estimated_db() - db) < 1);
}

std::vector<View> views_of(int count) {
  std::vector<View> views;
  for (const Camera& camera : builtin_cameras(count, columns, rows)) views.push_back(view_of(camera, {}));
  return views;
}

TEST_CASE("pages: an estimate of several views is that of the cut which they share") {
  check_near(ordered_scene(20000), views_of(8), {.pixels = 2});
}

TEST_CASE("pages: estimates of coarse cuts and of levels that fade are near what is measured") {
  const Scene scene = ordered_scene(20000);
  const std::vector<View> front = views_of(1);
  check_near(scene, front, {.pixels = 1000});
  check_near(scene, front, {.pixels = 0.5, .blend = 1e6});  // refines every page and shows the root
  constexpr std::size_t bytes = 3'000'000;
  Serial backend;
  PagePool<Serial> pool(backend, open(TestSource::of(scene)), {.bytes = bytes, .ahead = 0});
  const double allowed = pool.cut(all_of(front), {.pixels = 0}).pixels();
  for (const double part : {1.5, 0.7, 0.3})  // all levels fade as they should, some, and none
    check_near(scene, front, {.pixels = part * allowed, .blend = 1}, bytes);
}

TEST_CASE("pages: any change of a view is estimated anew") {
  const Scene scene = ordered_scene(2000);
  const PagedScene pages = open(TestSource::of(scene));
  Serial backend;
  PagePool<Serial> pool(backend, pages, {.estimate = 100'000'000});
  const Camera camera = builtin_camera(columns, rows);
  const auto near_of = [&](const Camera& from, const Conventions& conventions) {
    return std::vector<View>{view_of(from, conventions)};
  };
  const std::vector<View> plain = near_of(camera, {});
  std::vector<std::vector<View>> changed;
  changed.push_back(near_of(camera, {.blur = 4.0f}));
  changed.push_back(near_of(camera, {.antialiased = true}));
  changed.push_back(near_of(camera, {.near_plane = 6}));
  changed.push_back(near_of(camera, {.far_plane = 6}));
  changed.push_back(near_of(camera, {.alpha_min = 0.2f}));
  Camera fisheye = camera, moved = camera;
  fisheye.lens.model = LensModel::fisheye;
  moved.cx += 20;
  changed.push_back(near_of(fisheye, {}));
  changed.push_back(near_of(moved, {}));
  changed.push_back(plain);
  changed.back()[0].background = vec3(0.5f, 1, 0);
  Camera larger = camera;
  larger.width += 256, larger.height += 256;
  changed.push_back({make_view(larger, {}, {.width = columns, .height = rows}, {}, {.x = 128, .y = 128})});
  const CutGoal goal{.pixels = 1000};
  const double before = estimate_of(pool, plain, goal);
  for (std::size_t i = 0; i < changed.size(); ++i) {
    INFO("change ", i);
    PagePool<Serial> fresh(backend, pages, {.estimate = 100'000'000});
    const double expected = estimate_of(fresh, changed[i], goal);
    CHECK(expected != before);
    CHECK(estimate_of(pool, plain, goal) == before);
    CHECK(estimate_of(pool, changed[i], goal) == expected);
  }
}

TEST_CASE("pages: a page that could not be read for an estimate is tried again by the next wait") {
  const auto source = TestSource::of(ordered_scene(5000));
  Serial backend;
  PagePool<Serial> pool(backend, open(source), {.estimate = 100'000'000});
  const std::vector<View> views{view_of(builtin_camera(columns, rows), {})};
  source->before_read = [] { throw std::runtime_error("no network"); };
  const CutGoal root{.pixels = 1e6};
  CHECK(std::isnan(estimate_of(pool, views, root)));
  source->before_read = [] {};
  CHECK(estimate_of(pool, views, root) > 0);
}

TEST_CASE("pages: a pool that is destroyed does not read the other pages of an estimate") {
  const auto source = TestSource::of(ordered_scene(20000));
  const PagedScene pages = open(source);
  Serial backend;
  std::atomic<std::size_t> reads = 0;
  {
    PagePool<Serial> pool(backend, pages, {.estimate = 100'000'000});
    source->before_read = [&] {
      ++reads;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    };
    const View view = view_of(builtin_camera(columns, rows), {});
    pool.cut({&view, 1}, {.pixels = 1e6});  // itself it reads nothing more
    while (reads == 0) std::this_thread::yield();
  }
  CHECK(reads < pages.pages().size / 4);
}

TEST_CASE("pages: nothing is estimated without enough memory and where pages cannot be read") {
  const auto source = TestSource::of(ordered_scene(5000));
  const PagedScene pages = open(source);
  Serial backend;
  CHECK_THROWS_WITH_AS(PagePool<Serial>(backend, pages, {.estimate = 1000}),
                       doctest::Contains("estimate: 1000 bytes, expected "), InvalidArgument);
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
