// SPDX-License-Identifier: Apache-2.0
#include "policies/any_renderer.hpp"

#include <cmath>
#include <cstddef>
#include <memory>
#include <stdexcept>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/memory/scene_arrays.hpp>
#include <swiftgs/swiftgs.hpp>

#include "policies/hooked.hpp"
#include "policies/placed_list.hpp"

namespace swiftgs::test::any_renderer_test {

namespace {

constexpr const char* plain = "serial/early/per-pixel/ellipse";
constexpr const char* other_sort = "serial/standard/per-pixel/ellipse";

std::shared_ptr<const Scene> small_scene() { return std::make_shared<const Scene>(make_builtin_scene(500)); }
Camera small_camera() { return scaled(builtin_camera(), 0.05); }
Frame drawn_by(AnyRenderer& renderer) {
  Frame frame;
  renderer.render(small_camera(), {}, frame);
  return frame;
}

}  // namespace

TEST_CASE("any renderer: a scene is shared within a backend and drawn as an uploaded one") {
  const std::unique_ptr<AnyRenderer> first = make_renderer(plain), second = make_renderer(other_sort);
  CHECK_FALSE(second->share_scene(*first));
  CHECK_THROWS_AS(second->render_resident(small_camera(), {}), std::logic_error);
  first->set_scene(small_scene());
  REQUIRE(second->share_scene(*first));
  CHECK(drawn_by(*second).colour == drawn_by(*first).colour);
  for (const RendererEntry& entry : renderers()) {  // but not across backends
    if (!entry.usable || entry.name.starts_with("serial/")) continue;
    CHECK_FALSE(entry.make()->share_scene(*first));
    break;
  }
}

TEST_CASE("any renderer: scenes of the caller show in place of its own until others are placed") {
  for (const char* name : {plain, "cpu/early/per-pixel/ellipse"}) {
    const std::unique_ptr<AnyRenderer> renderer = make_renderer(name), other = make_renderer(name);
    other->set_scene(small_scene());
    const Frame alone = drawn_by(*other);
    const UploadedScene kept = renderer->upload(*small_scene());
    const std::vector<PlacedScene> placed{{kept.view()}};
    renderer->show({placed.data(), placed.size()});
    CHECK(drawn_by(*renderer).colour == alone.colour);
    renderer->show({});
    CHECK(drawn_by(*renderer).colour == std::vector<float>(alone.colour.size()));
    PlacedScene wrong{kept.view()};
    wrong.opacity = 2;
    CHECK_THROWS_AS(renderer->show({&wrong, 1}), InvalidArgument);
    renderer->set_scene(std::make_shared<const Scene>(make_builtin_scene(100)));
    CHECK(drawn_by(*renderer).colour != alone.colour);
  }
}

TEST_CASE("any renderer: frames are timed if asked to and a scene that is refused leaves the one before") {
  const std::unique_ptr<AnyRenderer> renderer = make_renderer(plain);
  renderer->set_scene(small_scene());
  const Frame before = drawn_by(*renderer);
  CHECK(std::isnan(renderer->times().total));
  RenderSettings timing;
  timing.time = true;
  renderer->render_resident(small_camera(), timing);
  CHECK(renderer->times().total > 0);
  CHECK_FALSE(renderer->device_memory().has_value());
  SceneArrays none{.count = 3};
  CHECK_THROWS_WITH_AS(renderer->set_scene(none), doctest::Contains("means is null"), std::invalid_argument);
  CHECK(drawn_by(*renderer).colour == before.colour);
}

TEST_CASE("any renderer: an adaptive sort decides after a few frames and any other has decided") {
  const std::unique_ptr<AnyRenderer> renderer = make_renderer("serial/adaptive/per-pixel/ellipse");
  renderer->set_scene(small_scene());
  CHECK_FALSE(renderer->sort_decided());
  for (int frame = 0; frame < 20 && !renderer->sort_decided(); ++frame) drawn_by(*renderer);
  CHECK(renderer->sort_decided());
  CHECK(make_renderer(plain)->sort_decided());
}

namespace {

/// Two scenes of a renderer, the second of them twice, and what its type takes for that.
template <class B>
struct TwoScenes {
  explicit TwoScenes(B& backend) : uploaded{backend.upload(given[0]), backend.upload(given[1])} {}

  std::vector<Placement> placements(double aside) const {
    return {{.scene = 1, .world_from_scene = moved(0.6, dvec3(aside, 0.2, 1))},
            {.first = 128},
            {.scene = 1,
             .opacity = 0.5f,
             .clip = Clip::sphere(vec3(0, 0, 5), 4),
             .tint = {vec3(1, 0, 0.5f), 0.4f},
             .first = 7,
             .count = 100}};
  }
  std::vector<PlacedScene> placed(double aside) const {
    std::vector<PlacedScene> out;
    for (const Placement& p : placements(aside))
      out.push_back({uploaded[p.scene].view(), p.world_from_scene, p.opacity, p.clip, p.tint});
    out[1].scene = range_of(out[1].scene, 128, 172), out[2].scene = range_of(out[2].scene, 7, 100);
    return out;
  }

  std::shared_ptr<const Scene> given[2] = {std::make_shared<const Scene>(random_scene(300, 1, 7)),
                                           std::make_shared<const Scene>(random_scene(120, 1, 8))};
  typename B::SceneOn uploaded[2];
};

/// Records a frame of `views`.
template <class B>
void record_into(AnyRenderer& any, const PlacedViews<B>& views, Report<B>& report) {
  any.set_views(views.span());
  any.record(report.data());
  any.wait();
}

}  // namespace

SWIFTGS_CONTRACT("any renderer: scenes that are added and placed are drawn and recorded as its type does") {
  Usual<B> typed(test::make_backend<B>());
  TwoScenes<B> two(typed.backend());
  const auto any = make_renderer(typed.name, {.threads = 1});
  CHECK(any->add_scene(two.given[0]) == 0);
  check_drawn_frames(*any, typed, two.uploaded[0]);
  CHECK(any->add_scene(two.given[1]) == 1);
  const std::vector<PlacedScene> where_they_stand{{two.uploaded[0].view()}, {two.uploaded[1].view()}};
  check_drawn_frames(*any, typed, where_they_stand);

  any->place(span_of(two.placements(0.3)));
  const std::vector<PlacedScene> placed = two.placed(0.3), moved = two.placed(-0.4);
  check_drawn_frames(*any, typed, placed);
  check_recorded_frames(*any, typed, placed);

  // What is recorded stays until it is told to follow.
  const std::vector<AskedView> asked = different_views();
  PlacedViews drawn(backend, asked), before(backend, asked), after(backend, asked);
  for (PlacedViews<B>* views : {&drawn, &before, &after}) views->views[1].shows = {1, 2};
  typed.render_into(placed, before.span());
  typed.render_into(moved, after.span());
  CHECK(differing(before.finish(backend), after.finish(backend)) > 0);
  Report<B> report;
  any->reserve(drawn.span(), {2000, 40'000});
  any->place(span_of(two.placements(-0.4)));
  any->record(report.data());
  any->wait();
  CHECK(differing(drawn.finish(backend), before.finish(backend)) == 0);
  PlacedViews followed(backend, asked);
  followed.views[1].shows = {1, 2};
  any->set_recorded_scenes();
  record_into(*any, followed, report);
  CHECK(differing(followed.finish(backend), after.finish(backend)) == 0);

  // Another renderer shares scenes and placements, and keeps them when this one takes another scene.
  const auto other = make_renderer(typed.name, {.threads = 1});
  REQUIRE(other->share_scene(*any));
  any->set_scene(two.given[1]);
  check_drawn_frames(*any, typed, two.uploaded[1]);
  check_drawn_frames(*other, typed, moved);
  CHECK(any->add_scene(two.given[0]) == 1);
  CHECK(other->add_scene(two.given[0]) == 2);
  std::vector<PlacedScene> more = moved;
  more.push_back({two.uploaded[0].view()});
  check_drawn_frames(*other, typed, more);
}

SWIFTGS_CONTRACT("any renderer: one of types keeps scenes too and tells them from those of its caller") {
  Usual<B> renderer(test::make_backend<B>()), typed(test::make_backend<B>());
  AnyRenderer& any = renderer;
  CHECK(any.name() == typed.name);
  TwoScenes<B> two(typed.backend());
  any.set_scene(two.given[0]);
  check_drawn_frames(any, typed, two.uploaded[0]);
  const auto named = make_renderer(typed.name, {.threads = 1});
  REQUIRE(named->share_scene(any));
  check_drawn_frames(*named, typed, two.uploaded[0]);

  const std::vector<AskedView> asked = different_views();
  const std::vector<PlacedScene> placed = two.placed(0.3);
  PlacedViews of_caller(backend, asked), kept(backend, asked);
  typed.render_into(placed, of_caller.span());
  typed.render_into(two.uploaded[0], kept.span());
  Report<B> report;
  PlacedViews drawn(backend, asked), again(backend, asked);
  renderer.reserve(placed, drawn.span(), {4000, 400'000});
  record_into(any, drawn, report);
  CHECK(differing(drawn.finish(backend), of_caller.finish(backend)) == 0);
  any.reserve(again.span(), {4000, 400'000});
  record_into(any, again, report);
  CHECK(differing(again.finish(backend), kept.finish(backend)) == 0);
}

SWIFTGS_CONTRACT("any renderer: recorded frames show the poses that work writes to their memory") {
  Usual<B> typed(test::make_backend<B>());
  TwoScenes<B> two(typed.backend());
  const auto any = make_renderer(typed.name, {.threads = 1});
  for (const auto& scene : two.given) any->add_scene(scene);
  any->place(span_of(two.placements(0.3)));
  CHECK_THROWS_AS(any->visible_by_scene(), std::logic_error);
  CHECK_THROWS_WITH_AS(any->recorded_scenes(), "recorded_scenes: expected reserve of placed scenes before",
                       std::logic_error);

  const std::vector<AskedView> asked = different_views();
  PlacedViews drawn(backend, asked), still(backend, asked), moved(backend, asked);
  typed.render_into(two.placed(-0.4), moved.span());
  typed.render_into(two.placed(0.3), still.span());
  CHECK(differing(still.finish(backend), moved.finish(backend)) > 0);
  any->render_into(drawn.span());
  CHECK(any->visible_by_scene() == typed.visible_by_scene());

  Report<B> report;
  any->reserve(drawn.span(), {4000, 400'000});
  const auto write = [&](const Similarity& pose) {
    const Span<StoredScene> recorded = any->recorded_scenes();
    REQUIRE(recorded.size == 3);
    CopyToBackend<RecordedScenesOn<B>>::copy(Span<const Similarity>{&pose, 1},
                                             &recorded.data[0].world_from_scene);
  };
  const auto shows = [&](PlacedViews<B>& expected) {
    PlacedViews views(backend, asked);  // some are drawn over what they hold
    record_into(*any, views, report);
    return differing(views.finish(backend), expected.finish(backend)) == 0;
  };
  CHECK(shows(still));
  write(two.placements(-0.4)[0].world_from_scene);
  CHECK(shows(moved));
  write({.scale = -1});
  if constexpr (on_host<RecordedScenesOn<B>>) {
    CHECK_THROWS_WITH_AS(any->record(report.data()), "placed scene: expected a finite scale above 0",
                         std::invalid_argument);
  } else {
    CHECK_FALSE(shows(moved));
    CHECK(any->refused_scenes() == std::vector<std::size_t>{0});
  }
  any->set_recorded_scenes();
  CHECK(shows(still));
  CHECK(any->refused_scenes().empty());

  // A reserve that fails leaves nothing to write to.
  View empty = drawn.views[0];
  empty.frame.width = 0;
  CHECK_THROWS_AS(any->reserve({&empty, 1}), std::invalid_argument);
  CHECK_THROWS_AS(any->recorded_scenes(), std::logic_error);
  CHECK_THROWS_AS(any->record(report.data()), std::invalid_argument);

  any->set_scene(two.given[0]);
  any->reserve(drawn.span(), {4000, 400'000});
  CHECK_THROWS_AS(any->recorded_scenes(), std::logic_error);

  // A scene alone may take the place of one that was placed.
  const Placement aside{.world_from_scene = {.translation = dvec3(0.25, 0, 0)}};
  any->place({&aside, 1});
  any->reserve(drawn.span(), {4000, 400'000});
  CHECK(any->recorded_scenes().size == 1);
  any->set_scene(two.given[0]);
  any->set_recorded_scenes();
  CHECK(any->recorded_scenes().size == 1);
  PlacedViews alone(backend, asked);
  typed.render_into(two.uploaded[0], alone.span());
  CHECK(shows(alone));
}

SWIFTGS_CONTRACT("any renderer: what cannot be placed is refused and changes nothing") {
  Usual<B> typed(test::make_backend<B>());
  TwoScenes<B> two(typed.backend());
  const auto any = make_renderer(typed.name, {.threads = 1});
  const std::vector<Placement> placements = two.placements(0.3);
  CHECK_THROWS_WITH_AS(any->place(span_of(placements)), "place: the scene is number 1, expected less than 0",
                       std::invalid_argument);
  CHECK_THROWS_AS(any->set_recorded_scenes(), std::logic_error);
  for (const auto& scene : two.given) any->add_scene(scene);
  any->place(span_of(placements));
  CHECK_THROWS_WITH_AS(any->set_recorded_scenes(), "render: expected reserve before set_scenes",
                       std::invalid_argument);
  CHECK_THROWS_WITH_AS(any->place({}), "place: expected one placement or more", std::invalid_argument);
  const auto refuse = [&](const Placement& wrong, const char* message) {
    const Placement both[] = {{}, wrong};
    CHECK_THROWS_WITH_AS(any->place({both, 2}), doctest::Contains(message), std::invalid_argument);
  };
  refuse({.scene = 2}, "place: the scene is number 2, expected less than 2");
  refuse({.opacity = 2}, "placed scene: expected an opacity of 0 to 1");
  refuse({.first = 1201, .count = 0},
         "place: placement 1 shows 0 Gaussians from number 1201 on, expected some of");
  refuse({.scene = 1, .first = 1, .count = std::size_t(-2)}, "expected some of the ");
  refuse({.first = std::size_t(-1)},
         "place: placement 1 shows all Gaussians from number 18446744073709551615 on,");

  const std::vector<AskedView> asked = different_views();
  PlacedViews drawn(backend, asked), expected(backend, asked);
  typed.render_into(two.placed(0.3), expected.span());
  any->render_into(drawn.span());
  any->wait();
  CHECK(differing(drawn.finish(backend), expected.finish(backend)) == 0);

  // Recorded frames take as many placed scenes of as many Gaussians.
  any->reserve(drawn.span(), {2000, 40'000});
  any->place({placements.data(), 2});
  CHECK_THROWS_WITH_AS(any->set_recorded_scenes(),
                       "set_scenes: the number of placed scenes is 2, expected 3 as reserved",
                       std::invalid_argument);
  // Those of scenes that are gone are not drawn.
  any->place(span_of(placements));
  any->set_scene(two.given[0]), any->add_scene(two.given[1]), any->place(span_of(placements));
  Report<B> report;
  CHECK_THROWS_WITH_AS(any->record(report.data()),
                       "render: expected reserve or set_recorded_scenes after other scenes were set",
                       std::invalid_argument);
  PlacedViews again(backend, asked);
  any->set_recorded_scenes();
  record_into(*any, again, report);
  CHECK(differing(again.finish(backend), expected.finish(backend)) == 0);
}

}  // namespace swiftgs::test::any_renderer_test
