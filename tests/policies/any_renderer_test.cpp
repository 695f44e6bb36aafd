// SPDX-License-Identifier: Apache-2.0
#include "policies/any_renderer.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/metrics.hpp>
#include <swiftgs/scene_arrays.hpp>
#include <swiftgs/swiftgs.hpp>

#include "policies/hooked.hpp"
#include "policies/placed_list.hpp"
#include "policies/rasterizers.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

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

/// Arrays of `floats.size() / 4` Gaussians that all read the same floats.
SceneArrays arrays_of(const std::vector<float>& floats) {
  const FloatArray all{floats.data()};
  SceneArrays arrays;
  arrays.count = floats.size() / 4, arrays.means = all, arrays.scales = all, arrays.rotations = all;
  arrays.opacities = all, arrays.sh0 = all;
  return arrays;
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

TEST_CASE("any renderer: arrays of any layout are drawn as the scene that has them") {
  const auto scene = small_scene();
  // A row for each Gaussian, as training stores it.
  struct Row {
    vec3 mean, log_scale, sh0;
    float rotation[4], logit, rest[45];
  };
  std::vector<Row> rows(scene->size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Quaternion q = scene->rotations[i];
    const vec3 scale = scene->scales[i];
    rows[i] = {.mean = scene->means[i],
               .log_scale = {std::log(scale.x), std::log(scale.y), std::log(scale.z)},
               .sh0 = scene->sh0[i],
               .rotation = {2 * q.w, 2 * q.x, 2 * q.y, 2 * q.z},
               .logit = std::log(scene->opacities[i] / (1 - scene->opacities[i])),
               .rest = {}};
    std::copy_n(scene->sh_rest.data() + 45 * i, 45, rows[i].rest);
  }
  const auto column = [](const float& first) { return FloatArray{&first, sizeof(Row)}; };
  const SceneArrays arrays{.count = rows.size(),
                           .means = column(rows[0].mean.x),
                           .scales = column(rows[0].log_scale.x),
                           .rotations = column(rows[0].rotation[0]),
                           .opacities = column(rows[0].logit),
                           .sh0 = column(rows[0].sh0.x),
                           .sh_rest = column(rows[0].rest[0]),
                           .sh_degree = 3,
                           .log_scales = true,
                           .logit_opacities = true,
                           .any_rotations = true};
  for (const char* name : {plain, "cpu/early/per-pixel/ellipse"}) {
    const std::unique_ptr<AnyRenderer> renderer = make_renderer(name);
    renderer->set_scene(scene);
    const Frame expected = drawn_by(*renderer);
    renderer->set_scene(arrays);
    CHECK(psnr(drawn_by(*renderer).colour, expected.colour) > 90);

    SceneArrays lower = arrays;
    lower.sh_degree = 1;
    renderer->set_scene(lower);
    const Frame of_lower = drawn_by(*renderer);
    CHECK(psnr(of_lower.colour, expected.colour) < 90);
    lower.means.stride = 8;
    CHECK_THROWS_WITH_AS(renderer->set_scene(lower), doctest::Contains("means: stride is 8 bytes, expected"),
                         std::invalid_argument);
    CHECK(drawn_by(*renderer).colour == of_lower.colour);  // the scene of before
    SceneArrays few = arrays;
    few.count = 10;
    renderer->set_scene(few);
    renderer->set_scene(arrays);
    CHECK(psnr(drawn_by(*renderer).colour, expected.colour) > 90);
  }
}

SWIFTGS_CASE_ON("any renderer: hosts take memory of arrays again unless somebody else has it",
                SWIFTGS_TEST_HOSTS) {
  constexpr std::size_t count = 20'000;
  std::vector<float> floats(4 * count, 0.5f);
  const SceneArrays arrays = arrays_of(floats);
  std::optional<HostScene> scene;
  scene.emplace(backend.upload(arrays, scene));
  const vec3* const first = scene->view().means.data;
  const std::uint64_t identity = scene->view().identity;
  scene.emplace(backend.upload(arrays, scene));
  CHECK(scene->view().means.data == first);
  CHECK(scene->view().identity != identity);
  {
    const HostScene shared = *scene;
    scene.emplace(backend.upload(arrays, scene));
    CHECK(scene->view().means.data != first);
    CHECK(shared.view().means[count - 1] == vec3(0.5f));
  }

  // A number of any block is found, and the scene stays.
  for (const std::size_t at : {std::size_t(0), std::size_t(1) << 14, 3 * count - 1}) {
    const std::string message = "means of Gaussian " + std::to_string(at / 3) + " is inf, expected";
    CAPTURE(message);
    const float kept = std::exchange(floats[at], std::numeric_limits<float>::infinity());
    const vec3* const before = scene->view().means.data;
    CHECK_THROWS_WITH_AS(scene.emplace(backend.upload(arrays, scene)), doctest::Contains(message.c_str()),
                         std::invalid_argument);
    CHECK(scene->view().means.data == before);
    CHECK(scene->view().means[at / 3] == vec3(0.5f));
    floats[at] = kept;
  }
}

TEST_CASE("any renderer: a resident frame is finished and counted as any other") {
  const std::unique_ptr<AnyRenderer> renderer = make_renderer(plain);
  renderer->set_scene(small_scene());
  drawn_by(*renderer);
  CHECK(std::isnan(renderer->times().total));
  const std::size_t intersections = renderer->statistics().intersections;
  RenderSettings counting;
  counting.count = counting.time = true;
  renderer->render_resident(small_camera(), counting);
  CHECK(renderer->times().total > 0);
  CHECK(renderer->statistics().intersections == intersections);
  CHECK(renderer->statistics().raster.contributing_pairs > 0);
  CHECK_FALSE(renderer->device_memory().has_value());
}

TEST_CASE("any renderer: an adaptive sort decides after a few frames and any other has decided") {
  const std::unique_ptr<AnyRenderer> renderer = make_renderer("serial/adaptive/per-pixel/ellipse");
  renderer->set_scene(small_scene());
  CHECK_FALSE(renderer->sort_decided());
  for (int frame = 0; frame < 20 && !renderer->sort_decided(); ++frame) drawn_by(*renderer);
  CHECK(renderer->sort_decided());
  CHECK(make_renderer(plain)->sort_decided());
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

SWIFTGS_CONTRACT("any renderer: every policy draws and records all that a view asks for as its type does") {
  const auto scene = std::make_shared<const Scene>(random_scene(300, 1, 7));
  const auto check = [&]<class Sort, class Raster, class Bounds>(Sort, Raster, Bounds) {
    Renderer<B, Sort, Raster, Bounds> typed(test::make_backend<B>());
    const auto uploaded = typed.backend().upload(scene);
    const auto any = make_renderer(typed.name, {.threads = 1});
    CAPTURE(std::string(typed.name));
    CHECK(any->name() == typed.name);
    any->set_scene(scene);
    check_drawn_frames(*any, typed, uploaded.view());
    check_recorded_frames(*any, typed, uploaded.view(), [&](FrameReport* report) { any->record(report); });
  };
  for_each_type(AllSorts(), [&](auto sort) {
    for_each_raster(
        [&](auto raster) { for_each_type(AllBounds(), [&](auto bounds) { check(sort, raster, bounds); }); });
  });
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
  check_recorded_frames(*any, typed, placed, [&](FrameReport* report) { any->record(report); });

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
  CHECK(any->visible_by_scene().size() == 3);

  Report<B> report;
  any->reserve(drawn.span(), {4000, 400'000});
  const auto write = [&](const Similarity& pose) {
    const Span<PlacedScene> recorded = any->recorded_scenes();
    REQUIRE(recorded.size == 3);
    CopyToBackend<B>::copy(Span<const Similarity>{&pose, 1}, &recorded.data[0].world_from_scene);
  };
  const auto shows = [&](PlacedViews<B>& expected) {
    PlacedViews views(backend, asked);  // some are drawn over what they hold
    record_into(*any, views, report);
    return differing(views.finish(backend), expected.finish(backend)) == 0;
  };
  CHECK(shows(still));
  write(two.placements(-0.4)[0].world_from_scene);
  for (int i = 0; i < 2; ++i) CHECK(shows(moved));  // what is written stays
  CHECK(any->refused_scenes().empty());
  write({.scale = -1});
  if constexpr (B::reaches_host_memory) {
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
  refuse({.world_from_scene = {.scale = -1}}, "placed scene: expected a finite scale above 0");
  refuse({.opacity = 2}, "placed scene: expected an opacity of 0 to 1");
  refuse({.first = 1201, .count = 0},
         "place: placement 1 shows 0 Gaussians from number 1201 on, expected some of");
  refuse({.scene = 1, .first = 1, .count = std::size_t(-2)}, "expected some of the ");
  refuse({.first = std::size_t(-1)},
         "place: placement 1 shows all Gaussians from number 18446744073709551615 on,");
  refuse({.clip = Clip::sphere(vec3(0), -1)}, "placed scene: expected a clip with a radius of 0 or more");
  refuse({.tint = {vec3(1), 2}}, "placed scene: expected a tint with an amount of 0 to 1");

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

  any->place({placements.data(), 2});
  drawn.views[0].shows = {2, 1};
  CHECK_THROWS_WITH_AS(any->render_into(drawn.span()),
                       doctest::Contains("a view shows 1 placed scenes from number 2 on, expected some of the"
                                         " frame's 2"),
                       std::invalid_argument);
}

SWIFTGS_CASE_ON("any renderer: hosts take features of arrays of any stride", SWIFTGS_TEST_HOSTS) {
  constexpr std::size_t count = 1000, stride = 7, channels = 5;
  std::vector<float> floats(4 * count, 0.5f), rows(stride * count);
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = float(i);
  SceneArrays arrays = arrays_of(floats);
  arrays.features = {rows.data(), stride * sizeof(float)}, arrays.feature_channels = channels;
  std::optional<HostScene> scene;
  scene.emplace(backend.upload(arrays, scene));
  const SceneView view = scene->view();
  REQUIRE(view.feature_channels == channels);
  REQUIRE(view.features.size == count);
  std::vector<float> by_floats(count * channels);
  const detail::CopyFloats copy{arrays.features, by_floats.data(), channels};  // as devices copy
  for (std::size_t i = 0; i < by_floats.size(); ++i) {
    const float feature = view.features.at(i / channels)[i % channels];
    REQUIRE(feature == rows[i / channels * stride + i % channels]);
    copy(i);
    REQUIRE(by_floats[i] == feature);
  }

  const auto refused = [&](const char* message) {
    CHECK_THROWS_WITH_AS(scene.emplace(backend.upload(arrays, scene)), doctest::Contains(message),
                         std::invalid_argument);
    CHECK(scene->view().features.data[1] == 1);  // the scene of before
  };
  rows[3 * stride + 2] = std::numeric_limits<float>::infinity();
  refused("features of Gaussian 3 is inf, expected");
  rows[3 * stride + 2] = 0;
  arrays.features.stride = 16;
  refused("features: stride is 16 bytes, expected 0 or a multiple of 4 from 20");
  arrays.features = {};
  refused("features is null, expected a pointer");
  arrays.feature_channels = -1;
  refused("feature_channels is -1, expected 0 or more");
  arrays.feature_channels = 0;
  scene.emplace(backend.upload(arrays, scene));
  CHECK(scene->view().features.empty());
}
