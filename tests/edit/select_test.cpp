// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/edit/all.hpp>
#include <swiftgs/tools/scene_part.hpp>

#include "policies/random_splats.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {
using Indices = std::vector<std::uint32_t>;
constexpr double infinity = std::numeric_limits<double>::infinity();

/// Gaussians at 0, 1, 2, ... along x.
Scene line(std::size_t count) {
  Scene scene = random_scene(count, 1, 4);
  for (std::size_t i = 0; i < count; ++i) scene.means[i] = vec3(float(i), 0, 0);
  return scene;
}

/// Checks that Gaussian `i` of `a` is `j` of `b`, bands that one of them lacks being 0.
void check_same(const Scene& a, std::size_t i, const Scene& b, std::size_t j) {
  CHECK(a.means[i] == b.means[j]);
  CHECK(a.scales[i] == b.scales[j]);
  CHECK(a.rotations[i] == b.rotations[j]);
  CHECK(a.opacities[i] == b.opacities[j]);
  CHECK(a.sh0[i] == b.sh0[j]);
  const std::size_t in_a = a.sh_rest.size() / a.size(), in_b = b.sh_rest.size() / b.size();
  for (std::size_t k = 0; k < in_a; ++k)
    CHECK(a.sh_rest[in_a * i + k] == (k < in_b ? b.sh_rest[in_b * j + k] : 0));
  REQUIRE(a.feature_channels == b.feature_channels);
  const auto channels = std::size_t(a.feature_channels);
  for (std::size_t k = 0; k < channels; ++k)
    CHECK(a.features[channels * i + k] == b.features[channels * j + k]);
}
}  // namespace

TEST_CASE("edit: a subset has all that its Gaussians had") {
  Scene scene = with_features(random_scene(10, 2, 3), 5);
  scene.model.antialiased = true;
  const Scene part = subset(scene, {7, 2});
  validate(part);
  REQUIRE(part.size() == 2);
  CHECK(part.sh_degree == 2);
  CHECK(part.model.antialiased);
  for (std::size_t i = 0; i < 2; ++i) check_same(part, i, scene, i == 0 ? 7 : 2);
  CHECK(subset(scene, {}).size() == 0);
  CHECK_THROWS_AS(subset(scene, {10}), std::invalid_argument);
}

TEST_CASE("edit: a predicate selects in order") {
  const Scene scene = line(5);
  CHECK(select(scene, [](std::size_t i) { return i % 2 == 0; }) == Indices{0, 2, 4});
  CHECK(select(scene, [&](std::size_t i) { return scene.means[i].x > 9; }).empty());
}

TEST_CASE("edit: regions keep the Gaussians whose means lie in them along every axis, borders included") {
  for (int axis = 0; axis < 3; ++axis) {
    CAPTURE(axis);
    Scene scene = line(10);
    for (vec3& mean : scene.means) std::swap(mean.x, mean[axis]);
    const auto kept = [&](const auto& region) {
      std::vector<float> found;
      for (const vec3& mean : crop(scene, region).means) found.push_back(mean[axis]);
      return found;
    };
    const auto on_axis = [&](double at, double beside) {
      dvec3 p(beside);
      p[axis] = at;
      return p;
    };
    using Places = std::vector<float>;
    CHECK(kept(Box{on_axis(2, -1), on_axis(4, 1)}) == Places{2, 3, 4});
    CHECK(kept(Box{on_axis(2, 0), on_axis(4, 0)}) == Places{2, 3, 4});
    CHECK(kept(Box{dvec3(-infinity), on_axis(1, infinity)}) == Places{0, 1});
    CHECK(kept(Sphere{on_axis(5, 0), 1}) == Places{4, 5, 6});
    CHECK(kept(Sphere{on_axis(5, 3), std::sqrt(18.0) + 0.01}) == Places{5});
    CHECK(kept(Sphere{on_axis(5, 0.5), 0.25}).empty());
    CHECK(kept(HalfSpace{on_axis(-2, 0), -4}) == Places{0, 1, 2});
    scene.means[3][(axis + 1) % 3] = std::numeric_limits<float>::quiet_NaN();
    CHECK(kept(Box{dvec3(-infinity), dvec3(infinity)}).size() == 9);
  }
}

TEST_CASE("edit: regions that are none are refused") {
  const Scene scene = line(2);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(crop(scene, Box{dvec3(1, 0, 0), dvec3(0, 1, 1)}), std::invalid_argument);
  CHECK_THROWS_AS(crop(scene, Box{dvec3(nan, 0, 0), dvec3(1)}), std::invalid_argument);
  CHECK_THROWS_AS(crop(scene, Sphere{dvec3(0), -1}), std::invalid_argument);
  CHECK_THROWS_AS(crop(scene, Sphere{dvec3(nan), 1}), std::invalid_argument);
  CHECK_THROWS_AS(crop(scene, HalfSpace{dvec3(0), 1}), std::invalid_argument);
  CHECK_THROWS_AS(crop(scene, HalfSpace{dvec3(1), nan}), std::invalid_argument);
  CHECK(crop(scene, HalfSpace{dvec3(1e-170, 0, 0), 0}).size() == 2);
  CHECK(crop(scene, Sphere{dvec3(0, 0, 1e200), 1e201}).size() == 2);
}

TEST_CASE("edit: another degree keeps what both have, and adds zeros") {
  const Scene scene = with_features(random_scene(4, 2, 9), 2);
  const Scene lower = with_degree(scene, 1), higher = with_degree(scene, 3);
  for (const Scene& other : {lower, higher}) {
    validate(other);
    for (std::size_t i = 0; i < 4; ++i) check_same(other, i, scene, i);
  }
  CHECK(lower.sh_degree == 1);
  CHECK(higher.sh_degree == 3);
  CHECK(with_degree(scene, 0).sh_rest.empty());
  CHECK(with_degree(higher, 2).sh_rest == scene.sh_rest);
  for (const int degree : {-1, 4}) CHECK_THROWS_AS(with_degree(scene, degree), std::invalid_argument);
}

TEST_CASE("edit: scenes are joined in order, with the higher degree") {
  const Scene low = with_features(random_scene(3, 1, 1), 2, 1),
              high = with_features(random_scene(2, 3, 2), 2, 2);
  for (const bool low_first : {true, false}) {
    const Scene &first = low_first ? low : high, &more = low_first ? high : low;
    Scene all = first;
    append(all, more);
    validate(all);
    CHECK(all.sh_degree == 3);
    REQUIRE(all.size() == 5);
    for (std::size_t i = 0; i < 5; ++i)
      i < first.size() ? check_same(all, i, first, i) : check_same(all, i, more, i - first.size());
  }
  Scene twice = low;
  append(twice, twice);
  REQUIRE(twice.size() == 6);
  check_same(twice, 5, low, 2);
}

TEST_CASE("edit: an antialiased scene is not joined with another") {
  Scene plain = random_scene(2, 0, 1), antialiased = random_scene(2, 0, 2), none;
  antialiased.model.antialiased = true;
  CHECK_THROWS_AS(append(plain, antialiased), std::invalid_argument);
  CHECK(plain.size() == 2);
  append(plain, none);
  CHECK_FALSE(plain.model.antialiased);
  append(none, antialiased);
  CHECK(none.model.antialiased);
  CHECK(none.size() == 2);
}

TEST_CASE("edit: scenes with different feature channels are not joined") {
  Scene plain = random_scene(2, 0, 1), none;
  const Scene featured = with_features(random_scene(2, 1, 2), 3);
  CHECK_THROWS_WITH_AS(append(plain, featured),
                       "append: expected scenes with equally many feature channels, got 0 and 3",
                       std::invalid_argument);
  CHECK(plain.size() == 2);
  append(none, featured);
  validate(none);
  CHECK(none.features == featured.features);
}

TEST_CASE("edit: moving and ordering keep features with their Gaussians") {
  Scene scene = with_features(random_scene(20, 1, 3), 3);
  const std::vector<std::uint32_t> order = spatial_order(scene);
  const Scene ordered = order_spatially(scene);
  for (std::size_t i = 0; i < order.size(); ++i) check_same(ordered, i, scene, order[i]);
  const std::vector<float> before = scene.features;
  transform(scene, {.scale = 2, .translation = dvec3(1, 2, 3)});
  CHECK(scene.features == before);
}

TEST_CASE("edit: parts of a scene have its features") {
  const Scene scene = with_features(random_scene(11, 2, 3), 4);
  Scene all = part_of(scene, {0, 3});
  for (std::size_t i = 1; i < 3; ++i) append(all, part_of(scene, {i, 3}));
  REQUIRE(all.size() == scene.size());
  for (std::size_t i = 0; i < all.size(); ++i) check_same(all, i, scene, i);
}
