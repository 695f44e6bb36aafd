// SPDX-License-Identifier: Apache-2.0

// Frames that are recorded: the memory that they are reserved, and the views that they may have.
#include <algorithm>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "policies/hooked.hpp"
#include "policies/planes.hpp"
#include "policies/rasterizers.hpp"

namespace swiftgs::test::record_test {

namespace {

using Threshold = AxisSharedThreshold<FloatCholesky>;

/// The most that any of the frames takes.
template <class B>
Capacity most_of(BoundRenderer<B>& renderer, const SceneView& scene, int frames, int views) {
  Capacity most;
  for (int i = 0; i < frames; ++i) {
    draw_together(renderer, scene, asked_of(i, views));
    const Statistics taken = renderer.statistics();
    most.splats = std::max(most.splats, taken.visible);
    most.intersections = std::max(most.intersections, taken.intersections);
  }
  return most;
}

/// Records 50 frames of a renderer that was reserved by the first, and looks for calls of its hook.
template <class B, class Sort, class Raster, class Bounds>
void record_without_calls(int threads, std::size_t gaussians, int views, std::size_t spare) {
  CAPTURE(threads);
  CAPTURE(views);
  constexpr int frames = 50;
  Hooked<B> memory, of_other;
  Renderer<B, Sort, Raster, Bounds> renderer(memory.backend(threads)), other(of_other.backend(threads));
  const auto scene = other.backend().upload(random_scene(gaussians, 1, 6)),
             empty = other.backend().upload(Scene());
  const Capacity most = most_of(other, scene.view(), frames, views);
  PlacedViews images(other.backend(), asked_of(0, views));
  draw_together(other, scene.view(), asked_of(0, views));
  CHECK(other.statistics().intersections + 100 < most.intersections);  // later frames take more
  CHECK(other.statistics().visible < most.splats);

  Report<B> memory_of_report;
  renderer.reserve(scene.view(), images.span(), {most.splats + spare, most.intersections + spare});
  const std::size_t calls = memory.calls();
  for (int i = 0; i < frames; ++i) {
    CAPTURE(i);
    PlacedViews drawn(other.backend(), asked_of(i, views));
    renderer.set_views(drawn.span());
    const std::size_t own = own_allocations;
    renderer.record(scene.view(), memory_of_report.data());
    if (on_host<B>) CHECK(own_allocations == own);
    const auto wanted = draw_together(other, scene.view(), asked_of(i, views));
    const FrameReport report = memory_of_report.get(renderer.backend());
    CHECK(report.overflowed == 0);
    CHECK(report.visible == other.statistics().visible);
    CHECK(report.intersections == other.statistics().intersections);
    CHECK(differing(drawn.finish(renderer.backend()), wanted) == 0);
  }
  renderer.set_views(images.span());
  renderer.record(empty.view(), memory_of_report.data());
  CHECK(memory_of_report.get(renderer.backend()).visible == 0);
  CHECK(memory.calls() == calls);
}

}  // namespace

TEST_CASE_TEMPLATE("record: never calls the hook after reserve", T, SWIFTGS_SORTS_ON_BACKENDS) {
  using B = typename T::Backend;
  using Sort = typename T::SortPolicy;
  if (unavailable_backend<B>()) return;
  if constexpr (std::is_same_v<B, Serial>) {
    record_without_calls<B, Sort, Threshold, Ellipse>(1, 2000, 1, 1000);
    record_without_calls<B, Sort, PerPixel, ThreeSigmaSquare>(1, 1000, 2, 0);
  } else {
    constexpr std::size_t gaussians = has_shaders<B> ? 2000 : 40'000;
    record_without_calls<B, Sort, Threshold, Ellipse>(2, gaussians, 1, 10);
    record_without_calls<B, Sort, Threshold, OpacityBox>(1, gaussians / 2, 2, 5000);
  }
}

SWIFTGS_CONTRACT("record: planes are those that were reserved, and no frame calls the hook for any") {
  Hooked<B> memory;
  Usual<B> renderer(memory.backend()), other;
  const auto scene = other.backend().upload(with_features(random_scene(2000, 1, 6), 20));
  const auto asked = [](int k) {
    std::vector<AskedView> views{changing_view(k), changing_lean_view(k), changing_view(k + 1),
                                 changing_view(k + 2)};
    views[0].further = all_planes(20), views[2].further = {.median_depth = true, .features = 2};
    views[3].further = {.normal = true, .id = true};
    return views;
  };
  PlacedViews reserved(other.backend(), asked(0));
  renderer.reserve(scene.view(), reserved.span(), {8000, 200'000});
  const std::size_t calls = memory.calls();
  Report<B> report;
  for (int k = 0; k < 6; ++k) {
    CAPTURE(k);
    PlacedViews drawn(other.backend(), asked(k));
    renderer.set_views(drawn.span());
    const std::size_t own = own_allocations;
    renderer.record(scene.view(), report.data());
    if (on_host<B>) CHECK(own_allocations == own);
    CHECK(report.get(renderer.backend()).overflowed == 0);
    CHECK(differing(drawn.finish(renderer.backend()), draw_together(other, scene.view(), asked(k))) == 0);
  }
  CHECK(memory.calls() == calls);
  const auto refuses = [&](const auto& change) {
    std::vector<View> views = reserved.views;
    change(views[2].frame);
    CHECK_THROWS_WITH_AS(renderer.set_views(span_of(views)),
                         doctest::Contains("conversion of colours of view 2 changed"), std::invalid_argument);
  };
  refuses([](FrameView& frame) { frame.median_depth = {}; });
  refuses([](FrameView& frame) { frame.feature_channels = 1; });
  refuses([](FrameView& frame) { frame.conversion = Conversion::linear_to_srgb; });
  refuses([&](FrameView& frame) { frame.id = reserved.views[0].frame.id; });
  const auto plain = other.backend().upload(random_scene(2000, 1, 6));
  CHECK_THROWS_WITH_AS(renderer.record(plain.view(), report.data()),
                       doctest::Contains("asks for 20 features a Gaussian, expected at most the 0"),
                       std::invalid_argument);
}

TEST_CASE_TEMPLATE("record: a frame without enough capacity draws nothing and one with just enough is drawn",
                   T, SWIFTGS_SORTS_ON_BACKENDS) {
  using B = typename T::Backend;
  if (unavailable_backend<B>()) return;
  Hooked<B> memory;
  Usual<B, typename T::SortPolicy> renderer(memory.backend()), other;
  const auto scene = other.backend().upload(random_scene(3000, 1, 7));
  for (const int views : {1, 2}) {
    const std::vector<AskedView> asked = asked_of(24, views);
    const auto expected = draw_together(other, scene.view(), asked);
    const Statistics taken = other.statistics();
    const auto record = [&](Capacity capacity, bool fits) {
      PlacedViews images(other.backend(), asked);
      Report<B> report;
      renderer.reserve(scene.view(), images.span(), capacity);
      const std::size_t calls = memory.calls();
      renderer.record(scene.view(), report.data());
      CHECK(memory.calls() == calls);
      const FrameReport found = report.get(renderer.backend());
      CHECK(found.visible == taken.visible);
      CHECK(found.overflowed == !fits);
      const auto untouched = PlacedViews(other.backend(), asked).finish(other.backend());
      CHECK(differing(images.finish(renderer.backend()), fits ? expected : untouched) == 0);
      return found.intersections;
    };
    record({taken.visible - 1, taken.intersections}, false);
    CHECK(record({taken.visible, taken.intersections - 1}, false) == taken.intersections);
    CHECK(record({taken.visible, taken.intersections}, true) == taken.intersections);
    record({1, 1}, false);
    CHECK(record({}, true) == taken.intersections);  // measured
    if (!on_host<B>) continue;
    CHECK(record({taken.visible, 0}, true) == taken.intersections);
    CHECK(record({0, taken.intersections}, true) == taken.intersections);
    // No more than can ever be shown is taken.
    const std::size_t most = std::numeric_limits<std::size_t>::max();
    record({most, taken.intersections}, true);
  }
}

TEST_CASE("record: an ordinary frame in between does not change the views that were set") {
  Usual<Serial> renderer;
  const auto scene = renderer.backend().upload(random_scene(500, 1, 8));
  const auto expected = draw_together(renderer, scene.view(), asked_of(3, 2));
  PlacedViews images(renderer.backend(), asked_of(3, 2));
  renderer.reserve(scene.view(), images.span());
  draw_together(renderer, scene.view(), asked_of(9, 5));
  FrameReport report;
  renderer.record(scene.view(), &report);
  CHECK(differing(images.finish(renderer.backend()), expected) == 0);
}

TEST_CASE("record: takes views of the sizes that were reserved and no others") {
  Usual<Serial> renderer;
  const auto scene = renderer.backend().upload(random_scene(500, 1, 9));
  const auto more = renderer.backend().upload(random_scene(501, 1, 9));
  const std::vector<AskedView> asked = asked_of(3, 2);
  PlacedViews images(renderer.backend(), asked), one(renderer.backend(), {asked[0]}),
      other_way(renderer.backend(), {asked[1], asked[0]});
  FrameReport report;
  CHECK_THROWS_AS(renderer.record(scene.view(), &report), std::invalid_argument);
  renderer.set_views(one.span());  // there is nothing yet to compare with
  renderer.reserve(scene.view(), images.span());
  CHECK_THROWS_WITH_AS(renderer.set_views(one.span()),
                       "set_views: the number of views is 1, expected 2 as reserved", std::invalid_argument);
  CHECK_THROWS_WITH_AS(renderer.set_views(other_way.span()),
                       doctest::Contains("conversion of colours of view 0 changed"), std::invalid_argument);
  CHECK_THROWS_WITH_AS(renderer.record(more.view(), &report),
                       "Gaussians in a recorded frame: 501 needed, the limit is 500", CapacityError);
  CHECK_THROWS_AS(renderer.record(scene.view(), nullptr), std::invalid_argument);
  renderer.record(scene.view(), &report);  // the views that were set before
  CHECK(differing(images.finish(renderer.backend()), draw_together(renderer, scene.view(), asked)) == 0);
  renderer.reserve(scene.view(), one.span());  // may change them
  renderer.record(scene.view(), &report);
  CHECK(differing(one.finish(renderer.backend()), draw_together(renderer, scene.view(), {asked[0]})) == 0);
}

SWIFTGS_CONTRACT("record: lenses may change, and pinholes stay pinholes") {
  Usual<B> renderer, other;
  const auto scene = renderer.backend().upload(random_scene(3000, 1, 12));
  const std::vector<AskedView> pinholes = asked_of(3, 2);
  std::vector<AskedView> lenses = pinholes;
  lenses[0].camera.lens = {LensModel::perspective, {.radial = {0.05, -0.01}, .tangential = {1e-3, 2e-3}}};
  lenses[1].camera.lens.model = LensModel::fisheye;
  const std::vector<AskedView>* const turns[] = {&lenses, &pinholes, &lenses};
  Report<B> report;
  PlacedViews seen_as_reserved(renderer.backend(), lenses);
  renderer.reserve(scene.view(), seen_as_reserved.span(), {6000, 60'000});
  for (const std::vector<AskedView>* const asked : turns) {
    PlacedViews images(renderer.backend(), *asked);
    renderer.set_views(images.span());
    renderer.record(scene.view(), report.data());
    CHECK(report.get(renderer.backend()).overflowed == 0);
    CHECK(differing(images.finish(renderer.backend()), draw_together(other, scene.view(), *asked)) == 0);
  }
  PlacedViews without(renderer.backend(), pinholes);
  renderer.reserve(scene.view(), without.span());
  CHECK_THROWS_WITH_AS(renderer.set_views(seen_as_reserved.span()),
                       doctest::Contains("view 0 is no pinhole that takes depth z alone"),
                       std::invalid_argument);
}

SWIFTGS_CONTRACT("record: what is called between sort and raster may still draw the occluder") {
  Usual<B> renderer, other;
  const B& on = renderer.backend();
  const auto scene = on.upload(random_scene(2000, 1, 13));
  const std::vector<AskedView> asked = asked_of(3, 1);
  const auto expected = draw_together(other, scene.view(), asked);
  const std::size_t pixels = std::size_t(asked[0].width) * asked[0].height;
  const std::vector<float> before_all(pixels, 0), behind_all(pixels, 1e30f);
  auto depth = to_backend(on, before_all);
  PlacedViews<B> images(on, asked);
  images.views[0].frame.occluder = {depth.data(), std::ptrdiff_t(sizeof(float)) * asked[0].width};
  Report<B> report;

  renderer.reserve(scene.view(), images.span(), {4000, 40'000});
  int calls = 0;
  const auto uncover = [&] {
    ++calls;
    if (on_host<B>) CHECK(renderer.lists().intersections > 0);
    CopyToBackend<B>::copy(Span<const float>{behind_all.data(), pixels}, depth.data());
  };
  renderer.record(scene.view(), report.data(), uncover);
  CHECK(report.get(on).overflowed == 0);
  CHECK(calls == 1);
  CHECK(differing(images.finish(on), expected) == 0);

  // A host that does not rasterize does not call it either.
  renderer.reserve(scene.view(), images.span(), {1, 1});
  renderer.record(scene.view(), report.data(), uncover);
  CHECK(report.get(on).overflowed == 1);
  CHECK(calls == (on_host<B> ? 1 : 2));
}

}  // namespace swiftgs::test::record_test
