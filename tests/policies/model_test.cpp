// SPDX-License-Identifier: Apache-2.0

// Frames follow the rendering models of their scenes, on every backend.
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/reference.hpp>

#include "policies/placed_list.hpp"
#include "policies/planes.hpp"
#include "policies/rasterizers.hpp"
#include "policies/views.hpp"

namespace swiftgs::test::model_test {

namespace {

constexpr RenderingModel mip{.blur = 0.1f, .antialiased = true};
constexpr RenderingModel by_distance{.order = SplatOrder::distance};
constexpr RenderingModel linear{.colours = ColourSpace::linear};
constexpr RenderingModel all{0.1f, true, SplatOrder::distance, ColourSpace::linear};

Scene scene_of(const RenderingModel& model) {
  Scene scene = make_builtin_scene(3'000);
  scene.model = model;
  return scene;
}

/// From the side, so that orders by depth and by distance differ.
Camera wide_camera() {
  Camera camera = scaled(builtin_camera(), 0.08);
  camera.fx *= 0.4, camera.fy *= 0.4;
  return camera;
}

RenderSettings depths_by(const Conventions& conventions, vec3 background = vec3(0)) {
  RenderSettings settings;
  settings.conventions = conventions, settings.background = background;
  settings.outputs = {.alpha = true, .depth = true, .first_depth = true, .median_depth = true};
  return settings;
}

template <class B>
Frame draw(BoundRenderer<B>& renderer, const Scene& scene, const Conventions& conventions,
           vec3 background = vec3(0)) {
  const auto on = renderer.backend().upload(scene);
  return renderer.render(on, wide_camera(), depths_by(conventions, background));
}

std::vector<double> reference_of(const List& list, const Conventions& conventions) {
  const std::vector<ReferenceScene> scenes = for_reference(list);
  return render_reference(span_of(scenes), wide_camera(), conventions).colour;
}

double rms(const std::vector<float>& a, const std::vector<double>& b) {
  double sum = 0;
  REQUIRE(a.size() == b.size());
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum / double(a.size()));
}

}  // namespace

SWIFTGS_CONTRACT("model: a scene is drawn as it was trained, as if conventions said so") {
  Usual<B> renderer(make_backend<B>());
  const Frame usual = draw(renderer, scene_of({}), {});
  for (const RenderingModel& model : {mip, by_distance, linear, all}) {
    const Frame followed = draw(renderer, scene_of(model), {});
    CHECK(same_planes(followed, draw(renderer, scene_of({}), as_trained({}, model))));
    CHECK_FALSE(same_planes(followed, usual));
    CHECK(same_planes(usual, draw(renderer, scene_of(model), as_trained({}, {}))));
  }
}

SWIFTGS_CONTRACT("model: frames are those of the reference, in depths of the lens and over a background") {
  Usual<B> renderer(make_backend<B>());
  const vec3 background(0.2f, 0.5f, 0.9f);
  for (const RenderingModel& model : {RenderingModel(), mip, by_distance, linear, all}) {
    const Scene scene = scene_of(model);
    const Frame found = draw(renderer, scene, {}, background);
    const ReferenceFrame expected = render_reference(scene, wide_camera(), {}, dvec3(background));
    CHECK(rms(found.colour, expected.colour) < 1e-5);
    CHECK(rms(found.depth, expected.depth) < 1e-3);
    const ReferencePlanes planes = render_reference_planes(scene, wide_camera(), {});
    std::size_t apart = 0;
    for (std::size_t i = 0; i < found.median_depth.size(); ++i)
      apart += std::abs(found.median_depth[i] - planes.median_depth[i]) > 1e-4 * planes.median_depth[i];
    CHECK(apart < found.median_depth.size() / 500);
  }
}

SWIFTGS_CONTRACT("model: each of several placed scenes has its own blur and compensation") {
  Usual<B> renderer(make_backend<B>());
  const Scene plain = scene_of({}), filtered = scene_of(mip);
  const Similarity aside{dmat3(1.0), 0.5, dvec3(0.3, -0.2, 0.7)};
  for (const List& list :
       {List{{plain}, {filtered, aside}}, List{{filtered}, {plain}}, List{{filtered, aside}}}) {
    const ListOn on(renderer.backend(), list);
    const Frame found = renderer.render(on.placed, wide_camera(), depths_by({}));
    CHECK(rms(found.colour, reference_of(list, {})) < 1e-5);
    for (const bool antialiased : {false, true}) {
      Conventions one;
      one.antialiased = antialiased, one.blur = antialiased ? 0.1f : 0.3f;
      const Frame alike = renderer.render(on.placed, wide_camera(), depths_by(one));
      CHECK(rms(alike.colour, reference_of(list, one)) < 1e-5);
      CHECK((alike.colour == found.colour) == (antialiased && list.size() == 1));
    }
  }
}

SWIFTGS_CONTRACT("model: one order and one kind of colours rule a frame") {
  Usual<B> renderer(make_backend<B>());
  const Scene plain = scene_of({}), distant = scene_of(by_distance), light = scene_of(linear);
  const ListOn on(renderer.backend(), List{{plain}, {distant, {dmat3(1.0), 0.5, dvec3(1, 0, 2)}}});
  Conventions distance;
  distance.order = SplatOrder::distance;
  CHECK(same_planes(renderer.render(on.placed, wide_camera(), depths_by({})),
                    renderer.render(on.placed, wide_camera(), depths_by(distance))));

  const List both{{plain}, {light}};
  const ListOn mixed(renderer.backend(), both);
  CHECK_THROWS_WITH_AS(renderer.render(mixed.placed, wide_camera(), depths_by({})),
                       doctest::Contains("scenes of sRGB-encoded colours and of linear ones"),
                       std::invalid_argument);
  Conventions said;
  said.colours = ColourSpace::linear;
  CHECK(rms(renderer.render(mixed.placed, wide_camera(), depths_by(said)).colour, reference_of(both, said)) <
        1e-5);
}

SWIFTGS_CONTRACT("model: linear light is stored as it is where a frame wants it so") {
  Usual<B> renderer(make_backend<B>());
  const Camera camera = wide_camera();
  const auto draw_as = [&](const RenderingModel& model, Conversion conversion) {
    PlanesOn<B> planes(renderer.backend(), camera.width, camera.height, {});
    FrameView frame = planes.view();
    frame.conversion = conversion;
    renderer.render_into(renderer.backend().upload(scene_of(model)), camera, {}, frame);
    return planes.on_host(renderer.backend()).colour;
  };
  // The same coefficients, blended alike: a scene that says nothing has them as they are.
  CHECK(draw_as(linear, Conversion::srgb_to_linear) == draw_as({}, Conversion::as_is));
  CHECK(draw_as(linear, Conversion::as_is) == draw_as({}, Conversion::linear_to_srgb));
  CHECK(draw_as(linear, Conversion::linear_to_srgb) == draw_as({}, Conversion::linear_to_srgb));
}

SWIFTGS_CONTRACT("model: a view with an occluder is ordered by depth, and refuses to be told otherwise") {
  Usual<B> renderer(make_backend<B>());
  const Camera camera = wide_camera();
  const std::vector<float> occluder(std::size_t(camera.width * camera.height), 6.0f);
  const auto draw_behind = [&](const RenderingModel& model, const Conventions& conventions) {
    const auto on = renderer.backend().upload(scene_of(model));
    return draw_over_sevens(renderer, on, camera, depths_by(conventions), occluder).colour;
  };
  CHECK(draw_behind(by_distance, {}) == draw_behind({}, {}));
  Conventions distance;
  distance.order = SplatOrder::distance;
  CHECK_THROWS_WITH_AS(draw_behind({}, distance), doctest::Contains("expected order by depth"),
                       std::invalid_argument);
}

SWIFTGS_CONTRACT("model: recorded frames follow the scenes that they were reserved for") {
  Usual<B> renderer(make_backend<B>());
  const Camera camera = wide_camera();
  for (const RenderingModel& model : {mip, by_distance, all}) {
    const auto on = renderer.backend().upload(scene_of(model));
    const auto other = renderer.backend().upload(scene_of({}));
    PlanesOn<B> planes(renderer.backend(), camera.width, camera.height, {});
    const View view = make_view(camera, {}, planes.view());
    Report<B> report;
    renderer.reserve(on, {&view, 1});
    renderer.record(on.view(), report.data());
    CHECK(planes.on_host(renderer.backend()).colour == draw(renderer, scene_of(model), {}).colour);
    renderer.reserve(on, {&view, 1});
    CHECK_THROWS_WITH_AS(renderer.record(other.view(), report.data()), doctest::Contains("rendering model"),
                         std::invalid_argument);
  }
}

TEST_CASE("model: an impossible blur is refused") {
  for (const float blur : {-0.1f, INFINITY, NAN}) {
    Scene scene = scene_of({.blur = blur});
    CHECK_THROWS_AS(validate(scene), std::invalid_argument);
  }
}

}  // namespace swiftgs::test::model_test
