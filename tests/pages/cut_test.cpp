// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/cpu.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/metrics.hpp>
#include <swiftgs/pages/page_pool.hpp>
#include <swiftgs/swiftgs.hpp>

#include "pages/pools.hpp"

namespace swiftgs::test::cut_of_pages {
namespace {

TEST_CASE("pages: goal 0 has the bits of the scene through any lens and of two placed scenes") {
  const TemporaryFolder folder;
  const Scene scene = ordered_scene(6000);
  const PagedScene pages = pages_of(folder, scene);
  Renderer<Cpu> renderer;
  const auto whole = renderer.backend().upload(scene);
  const Similarity moved{.translation = dvec3(3, 0, 2)};
  PagePool<Cpu> pool(renderer.backend(), std::vector<PlacedPages>{{pages}, {pages, moved, 0.5f}});
  for (const LensModel lens : {LensModel::perspective, LensModel::fisheye, LensModel::orthographic}) {
    Camera camera = builtin_camera(width, height);
    camera.lens.model = lens;
    if (lens == LensModel::orthographic) camera.fx = camera.fy = 20;  // pixels per unit
    const std::vector<View> views{view_of(camera)};
    Cut cut = pool.cut(all_of(views), {.pixels = 0});
    pool.wait(cut);
    INFO(std::string(name_of(lens)));
    CHECK(cut.missing() == 0);
    const std::vector<PlacedScene> placed{{whole.view()}, {whole.view(), moved, 0.5f}};
    const std::vector<float> expected = renderer.render(placed, camera).colour;
    CHECK(renderer.render(cut.scenes(), camera).colour == expected);
    CHECK(psnr(expected, renderer.render(whole, camera).colour) < 60);  // the second one shows
  }
}

TEST_CASE("pages: goal 0 draws leaves where all Gaussians lie in one place") {
  const TemporaryFolder folder;
  Scene scene = make_builtin_scene(2000);
  std::fill(scene.means.begin(), scene.means.end(), vec3(0, -0.5f, 0));
  const PagedScene pages = pages_of(folder, scene);
  Renderer<Serial> renderer;
  PagePool<Serial> pool(renderer.backend(), pages);
  const std::vector<View> views = front();
  Cut cut = pool.cut(all_of(views), {.pixels = 0});
  pool.wait(cut);
  CHECK(cut.splats() == 2000);
  CHECK(cut.named(0).is_gaussian);
}

TEST_CASE("pages: a first cut draws the root and later ones come closer to the scene") {
  const TemporaryFolder folder;
  const Scene scene = ordered_scene(20000);
  const PagedScene pages = pages_of(folder, scene);
  Renderer<Cpu> renderer;
  PagePool<Cpu> pool(renderer.backend(), pages);
  const std::vector<View> views = front();
  const Camera camera = builtin_camera(width, height);
  const Frame whole = renderer.render(renderer.backend().upload(scene), camera);
  CHECK(pool.resident() == 1);
  const Cut first = pool.cut(all_of(views), {.pixels = 0});
  REQUIRE(first.scenes().size() == 1);
  CHECK(first.splats() == pages.pages()[pages.root()].count);
  CHECK(first.missing() > 0);
  CHECK(first.late() == 0);
  CHECK_FALSE(first.named(3).is_gaussian);
  double last = psnr(renderer.render(first.scenes(), camera).colour, whole.colour);
  std::uint64_t splats = first.splats();
  for (const double pixels : {16.0, 4.0, 1.0, 0.25}) {
    Cut cut = pool.cut(all_of(views), {.pixels = pixels});
    pool.wait(cut);
    CHECK(cut.missing() == 0);
    CHECK(cut.splats() == cut.wanted());
    CHECK(cut.splats() >= splats);
    check_no_hole(cut, pages, views);
    const double db = psnr(renderer.render(cut.scenes(), camera).colour, whole.colour);
    CHECK(db > last - 0.5);
    last = db, splats = cut.splats();
  }
  CHECK(last > 30);
}

TEST_CASE("pages: budgets of splats and memory are kept and the error that they allow is told") {
  const TemporaryFolder folder;
  const PagedScene pages = pages_of(folder, ordered_scene(20000));
  Renderer<Cpu> renderer;
  const std::vector<View> views = front();
  PagePool<Cpu> roomy(renderer.backend(), pages);
  Cut cut = roomy.cut(all_of(views), {.pixels = 0, .splats = 3000});
  roomy.wait(cut);
  CHECK(cut.splats() <= 3000);
  CHECK(cut.splats() > 2000);
  CHECK(cut.pixels() > 0);
  PagePool<Cpu> tight(renderer.backend(), pages, {.bytes = 1'000'000, .ahead = 0});
  cut = tight.cut(all_of(views), {.pixels = 0});
  tight.wait(cut);
  CHECK(cut.missing() == 0);
  CHECK(cut.pixels() > 0);
  CHECK(tight.bytes() <= 1'000'000);
  CHECK(tight.bytes() > 800'000);
  check_no_hole(cut, pages, views);
  CHECK_THROWS_AS(PagePool<Cpu>(renderer.backend(), pages, {.bytes = 1000}), InvalidArgument);
  CHECK_THROWS_AS(PagePool<Cpu>(renderer.backend(), pages, {.threads = 0}), InvalidArgument);
  CHECK_THROWS_AS(PagePool<Cpu>(renderer.backend(), pages, {.ahead = -1}), InvalidArgument);
  CHECK_THROWS_AS(roomy.cut(all_of(views), {.pixels = -1}), InvalidArgument);
}

TEST_CASE("pages: the same pages in memory draw the same bits whatever came before") {
  const PagedScene pages = open(TestSource::of(ordered_scene(10000)));
  Renderer<Cpu> renderer;
  const Camera camera = builtin_camera(width, height);
  const std::vector<View> views = front();
  const auto complete = [&](PagePool<Cpu>& pool) {
    Cut cut = pool.cut(all_of(views), {.pixels = 0.5});
    pool.wait(cut);
    return renderer.render(cut.scenes(), camera).colour;
  };
  PagePool<Cpu> fresh(renderer.backend(), pages), travelled(renderer.backend(), pages);
  for (const Camera& other : builtin_cameras(8, width, height)) {
    const std::vector<View> seen{view_of(other)};
    Cut cut = travelled.cut(all_of(seen), {.pixels = 0.1});
    travelled.wait(cut);
  }
  CHECK(complete(fresh) == complete(travelled));
}

TEST_CASE("pages: copies of a file share its pages and stereo views share a cut") {
  const PagedScene pages = open(TestSource::of(ordered_scene(5000)));
  Renderer<Cpu> renderer;
  const std::vector<PlacedPages> placed{{pages}, {pages, {.translation = dvec3(30, 0, 0)}}};
  PagePool<Cpu> pool(renderer.backend(), placed);
  CHECK(pool.resident() == 1);
  std::vector<View> views;
  for (const Camera& camera : builtin_cameras(2, width, height)) views.push_back(view_of(camera));
  Cut cut = pool.cut(all_of(views), {.pixels = 0});
  pool.wait(cut);
  CHECK(pool.resident() <= pages.pages().size);
  CHECK(cut.named(0).scene == 0);
  const NamedNode last = cut.named(std::uint32_t(cut.splats() - 1));
  CHECK(last.scene == 1);
  CHECK(last.is_gaussian);
  CHECK_THROWS_AS(cut.named(std::uint32_t(cut.splats())), InvalidArgument);
  CHECK_THROWS_AS(PagePool<Cpu>(renderer.backend(), std::vector<PlacedPages>()), InvalidArgument);
}

TEST_CASE("pages: cameras that go on as they do are where views ahead expect them") {
  detail::Motion motion(10), none(0);
  const std::vector<View> before{view_of(walker(5)), view_of(walker(20))},
      now{view_of(walker(6)), view_of(walker(21))};
  CHECK(motion.ahead(all_of(before)).empty());
  const std::vector<View> ahead = motion.ahead(all_of(now));
  REQUIRE(ahead.size() == 4);
  for (std::size_t i = 0; i < 4; ++i) {
    const ViewConstants expected = view_of(walker(std::array{8, 23, 16, 31}[i])).camera;
    for (int row = 0; row < 3; ++row) {
      CHECK(ahead[i].camera.centre[row] == doctest::Approx(expected.centre[row]));
      for (int column = 0; column < 3; ++column)
        CHECK(ahead[i].camera.rotation[row][column] == doctest::Approx(expected.rotation[row][column]));
    }
  }
  CHECK(motion.ahead(all_of(now)).empty());  // they stand still
  CHECK(motion.ahead({before.data(), 1}).empty());
  none.ahead(all_of(before));
  CHECK(none.ahead(all_of(now)).empty());
}

TEST_CASE("pages: levels that blend change pictures little at a time") {
  const PagedScene pages = open(TestSource::of(ordered_scene(20000)));
  Renderer<Cpu> renderer;
  const Camera camera = builtin_camera(width, height);
  const std::vector<View> views = front();
  PagePool<Cpu> pool(renderer.backend(), pages);
  // Largest mean square change where errors grow by 2 % of the goal a frame, as if a camera came closer.
  const auto largest_change = [&](double blend, int& faded) {
    double largest = 0;
    std::vector<float> last;
    for (double pixels = 8; pixels > 2; pixels /= 1.02) {
      Cut cut = pool.cut(all_of(views), {.pixels = pixels, .blend = blend});
      pool.wait(cut);
      CHECK(cut.splats() == cut.wanted());
      for (const PlacedScene& placed : cut.scenes()) faded += placed.opacity < 1;
      std::vector<float> colour = renderer.render(cut.scenes(), camera).colour;
      if (!last.empty()) largest = std::max(largest, std::pow(10, -psnr(colour, last) / 10));
      last = std::move(colour);
    }
    return largest;
  };
  int faded = 0;
  const double at_once = largest_change(0, faded);
  CHECK(faded == 0);
  CHECK(largest_change(0.5, faded) < 0.3 * at_once);
  CHECK(faded > 100);
  CHECK_THROWS_AS(pool.cut(all_of(views), {.blend = -1}), InvalidArgument);
}

TEST_CASE("pages: numbers of a cut are those of the source whatever order leaves have") {
  const TemporaryFolder folder;
  const Scene scene = make_builtin_scene(5000);
  Renderer<Cpu> renderer;
  for (const bool order : {false, true}) {
    PageBuildOptions options = small_pages();
    options.order = order;
    PagePool<Cpu> pool(renderer.backend(), pages_of(folder, scene, options));
    const std::vector<View> views = front();
    Cut cut = pool.cut(all_of(views), {.pixels = 0});
    pool.wait(cut);
    std::uint32_t number = 0;
    for (const PlacedScene& placed : cut.scenes())
      for (std::size_t i = 0; i < placed.size(); ++i, ++number)
        CHECK(placed.scene.means[i] == scene.means[cut.named(number).number]);
  }
}

}  // namespace
}  // namespace swiftgs::test::cut_of_pages
