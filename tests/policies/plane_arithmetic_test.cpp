// SPDX-License-Identifier: Apache-2.0

// What a pixel remembers of its splats, and what is summed of them.
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/attribute_stage.hpp>
#include <swiftgs/plane/attributes.hpp>
#include <swiftgs/plane/normal.hpp>
#include <swiftgs/plane/picks.hpp>
#include <swiftgs/plane/ray_depth.hpp>

#include "policies/random_splats.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

constexpr float largest_float = std::numeric_limits<float>::max();

/// Offers splats of these alphas, whose numbers count down to 0.
SplatPicks picks_of(const std::vector<float>& alphas, float first_below = 0.75f) {
  SplatPicks picks;
  float transmittance = 1;
  for (std::size_t i = 0; i < alphas.size(); ++i) {
    const float weight = alphas[i] * transmittance;
    transmittance -= weight;
    picks.offer(std::uint32_t(alphas.size() - 1 - i), weight, transmittance, first_below);
  }
  return picks;
}

/// A view with some planes, whose memory nobody touches.
View asks_for(bool normal, bool squared_depth, int features) {
  static float memory;
  View view;
  view.frame.feature_channels = features;
  if (normal) view.frame.normal.data = &memory;
  if (squared_depth) view.frame.squared_depth.data = &memory;
  if (features > 0) view.frame.features.data = &memory;
  return view;
}

/// What the attributes of a view are of, in order, with the number of their channels.
using Runs = std::vector<std::pair<Attribute::Of, int>>;
Runs runs_of(const View& view) {
  Runs runs;
  for (int k = 0; k < attribute_count(view); ++k) {
    const Attribute found = attribute(view, k);
    if (found.channel == 0) runs.emplace_back(found.of, 0);
    REQUIRE_FALSE(runs.empty());
    CHECK(found.of == runs.back().first);
    CHECK(found.channel == runs.back().second++);
  }
  return runs;
}

/// One Gaussian as a splat.
struct OneSplat {
  Scene scene;
  SplatShape shape;
  float depth = 2, alpha_max = 0.5f;
  std::uint32_t gaussian = 0;

  OneSplat() { append(scene, vec3(0, 0, 2), 1, 0.5f); }

  /// Four of its attributes in a frame.
  std::vector<float> attributes(View view, unsigned row = 0, int first = 0) const {
    view.camera = view_constants(forward_camera(8, 8), Conventions());
    view.rules.alpha_max = alpha_max;
    const SplatAttributes from{{{&shape, 1}, {&depth, 1}, {&gaussian, 1}}, first, 4};
    AttributeRow rows[AttributesView::most_rows];
    from.gather<true>(OneScene{swiftgs::view(scene)}, view, 0, rows);
    return {rows[row].values, rows[row].values + AttributeRow::channels};
  }
};

}  // namespace

TEST_CASE("planes: a pixel remembers the first splat, the median and the largest") {
  constexpr std::uint32_t none = SplatPicks::none;
  struct Row {
    std::vector<float> alphas;
    float first_below;
    std::uint32_t first, median, largest;
  };
  // Thresholds are passed and not reached. Of equal weights the nearer wins.
  for (const Row& row : {Row{{}, 0.75f, none, none, none},
                         {{0}, 0.75f, none, none, none},
                         {{0.125f, 0.25f, 0.5f, 0.5f}, 0.75f, 2, 1, 1},  // leave 0.875, 0.656, 0.328, 0.164
                         {{0.25f}, 0.75f, none, none, 0},
                         {{0.25f, 0.25f}, 0.75f, 0, none, 1},
                         {{0.5f}, 0.75f, 0, none, 0},
                         {{0.5f, 0.125f}, 0.75f, 1, 0, 1},
                         {{0.25f}, 1, 0, none, 0},
                         {{0.5f, 1}, 0.75f, 1, 0, 1}}) {
    CAPTURE(row.alphas.size());
    const SplatPicks picks = picks_of(row.alphas, row.first_below);
    CHECK(picks.first == row.first);
    CHECK(picks.median == row.median);
    CHECK(picks.largest == row.largest);
  }
  CHECK(picks_of({0.125f, 0.25f, 0.5f, 0.5f}).weight == 0.328125f);
}

TEST_CASE("planes: attributes are depths along the ray, normals, squared depths and features") {
  using enum Attribute::Of;
  CHECK(runs_of(View()) == Runs{});
  CHECK(runs_of(asks_for(true, false, 0)) == Runs{{normal, 3}});
  CHECK(runs_of(asks_for(true, true, 2)) == Runs{{normal, 3}, {squared_depth, 1}, {feature, 2}});
  CHECK(runs_of(asks_for(false, true, 1)) == Runs{{squared_depth, 1}, {feature, 1}});
  CHECK(runs_of(asks_for(false, false, 17)) == Runs{{feature, 17}});
  CHECK(attribute(asks_for(true, true, 2), 6).of == nothing);
  CHECK(attribute(asks_for(true, false, 0), 3).of == nothing);

  View view = asks_for(true, true, 1);
  view.camera.depth_along_ray = true;
  CHECK(runs_of(view) == Runs{{ray_depth, 3}, {normal, 3}, {squared_ray_depth, 6}, {feature, 1}});
  view = asks_for(true, false, 0), view.camera.depth_along_ray = true;
  CHECK(runs_of(view) == Runs{{normal, 3}});  // nothing asks for depth
  float memory;
  for (Plane<float>* plane : {&view.frame.depth, &view.frame.first_depth, &view.frame.median_depth}) {
    plane->data = &memory;
    CHECK(runs_of(view) == Runs{{ray_depth, 3}, {normal, 3}});
    *plane = {};
  }
  view.frame.occluder.data = &memory;
  CHECK(runs_of(view) == Runs{{ray_depth, 3}, {normal, 3}});
}

TEST_CASE("planes: the square of a depth along the ray is the sum of its coefficients") {
  const RayDepth depth{3, 0.5f, -0.25f};
  float squares[RayDepth::squares];
  for (int k = 0; k < RayDepth::squares; ++k) squares[k] = depth.square(k);
  CHECK(depth.at(vec2(2, 8)) == 2);
  CHECK(sum_of_squares(squares, vec2(2, 8)) == 4);
  CHECK(sum_of_squares(squares, vec2(0, 0)) == 9);
  CHECK(sum_of_squares(squares, vec2(-2, 4)) == 1);
}

TEST_CASE("planes: depth along the ray slopes as a card does and not where its square could not be summed") {
  Scene scene;
  append(scene, vec3(0.5f, 0, 2), 0.1f, 0.5f);
  scene.scales[0].x = 0;
  scene.rotations[0] = {0.9238795f, 0, 0.3826834f,
                        0};  // z goes to (1, 0, 1) / sqrt(2): the card is z = x + 1.5
  Camera camera = forward_camera(64, 48, 100);
  camera.lens.model = LensModel::orthographic;
  Conventions conventions;
  conventions.blur = 0;
  const auto depth = [&](float most_squared) {
    const vec2 mean(float(0.5 * camera.fx + camera.cx), float(camera.cy));
    return ray_depth(view_constants(camera, conventions), gaussian(view(scene), 0), mean, 2, most_squared);
  };
  CHECK(depth(1e38f).x == doctest::Approx(0.01));
  CHECK(depth(1e38f).y == doctest::Approx(0));
  CHECK(depth(1e38f).middle == doctest::Approx(1.5 + (32 - camera.cx) / 100));
  CHECK(depth(4).x == 0);
  CHECK(depth(4).middle == 2);
  conventions.blur = 0.5f;  // a hundredth of the card's variance: 10 pixels, seen from aside
  CHECK(depth(1e38f).x == doctest::Approx(0.01 / 1.01));
  scene.scales[0] = vec3(0);
  CHECK(depth(1e38f).x == 0);
  conventions.blur = 0;  // nothing to fit
  CHECK(depth(1e38f).x == 0);
  CHECK(depth(1e38f).middle == 2);
}

TEST_CASE("planes: each sum is stored where it belongs") {
  std::vector<float> normal(6, 9), squared(2, 9), features(4, 9);
  View view;
  FrameView& frame = view.frame;
  frame.normal = {normal.data(), 24}, frame.squared_depth = {squared.data(), 8};
  frame.features = {features.data(), 16}, frame.feature_channels = 2;
  const auto store = [&](int first, unsigned rows, std::size_t x, float transmittance) {
    float sums[AttributesView::most];
    for (int i = 0; i < int(AttributesView::most); ++i) sums[i] = float(first + i + 1);
    store_attributes(view, AttributesView{.rows = rows, .first = first}, x, 0, transmittance, sums);
  };
  store(0, 1, 1, 0.5f);
  CHECK(normal == std::vector<float>{9, 9, 9, 1, 2, 3});
  CHECK(squared == std::vector<float>{9, 8});
  CHECK(features == std::vector<float>{9, 9, 9, 9});
  store(4, 4, 1, 0.5f);
  CHECK(features == std::vector<float>{9, 9, 5, 6});
  store(8, 1, 0, 0.5f);  // another view asks for so many
  CHECK(normal[0] == 9);
  CHECK(features[0] == 9);
  store(0, 4, 0, 1);
  CHECK(squared == std::vector<float>{0, 8});
}

TEST_CASE("planes: rows of attributes are summed by weight") {
  const AttributeRow rows[] = {{{9, 9, 9, 9}}, {{9, 9, 9, 9}}, {{1, 2, 3, 4}}, {{5, 6, 7, 8}}};
  float sums[AttributesView::most] = {1, 1, 1, 1, 1, 1, 1, 1, 1};
  AttributesView{.data = rows, .rows = 2}.add(sums, 1, 0.5f);
  for (int i = 0; i < 8; ++i) CHECK(sums[i] == 1 + 0.5f * float(i + 1));
  CHECK(sums[8] == 1);
}

TEST_CASE("planes: of equally short axes the first is a normal") {
  CHECK(shortest_axis(vec3(1, 1, 1)) == 0);
  CHECK(shortest_axis(vec3(2, 1, 1)) == 1);
  CHECK(shortest_axis(vec3(1, 2, 1)) == 0);
  CHECK(shortest_axis(vec3(2, 2, 1)) == 2);
  CHECK(shortest_axis(vec3(3, 2, 1)) == 2);
  CHECK(shortest_axis(vec3(2, 1, 3)) == 1);
}

TEST_CASE("planes: a normal points against the ray and along the axis of an orthographic lens") {
  Scene scene;
  append(scene, vec3(3, 0, 2), 1, 0.5f);
  scene.scales[0] = vec3(0.1f, 1, 1);
  scene.rotations[0] = {0.9238795f, 0, 0.3826834f, 0};  // by pi/4 about y: x goes to (1, 0, -1) / sqrt(2)
  Camera camera = forward_camera(8, 8);
  const auto normal = [&] { return splat_normal(view_constants(camera, Conventions()), view(scene), 0); };
  CHECK(normal().z == doctest::Approx(0.70710678));  // the ray goes by (3, 0, 2)
  CHECK(normal().x == doctest::Approx(-0.70710678));
  camera.lens.model = LensModel::orthographic;
  CHECK(normal().z == doctest::Approx(-0.70710678));
  CHECK(normal().x == doctest::Approx(0.70710678));
}

TEST_CASE("planes: attributes are cut to what sums in units of alpha_max can hold, and to 0 if not finite") {
  using Row = std::vector<float>;
  OneSplat splat;
  splat.scene.feature_channels = 2;
  for (const float bad : {INFINITY, -INFINITY, NAN}) {
    splat.scene.features = {bad, -3};
    CHECK(splat.attributes(asks_for(false, false, 2)) == Row{0, -3, 0, 0});
  }
  splat.scene.features = {largest_float, -largest_float};
  const float most = most_attribute(splat.alpha_max);
  CHECK(most / splat.alpha_max < largest_float);
  CHECK(splat.attributes(asks_for(false, false, 2)) == Row{most, -most, 0, 0});
  CHECK(splat.attributes(asks_for(false, true, 0)) == Row{4, 0, 0, 0});
  CHECK(splat.attributes(asks_for(true, true, 2)) == Row{1, 0, 0, 4});  // across the ray
  CHECK(splat.attributes(asks_for(true, true, 2), 1) == Row{most, -most, 0, 0});
  CHECK(splat.attributes(asks_for(true, true, 2), 0, 3) == Row{4, most, -most, 0});
  splat.depth = 1e30f;
  CHECK(splat.attributes(asks_for(false, true, 0)) == Row{most, 0, 0, 0});
}
