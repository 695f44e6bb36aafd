// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/edit.hpp>

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
}  // namespace

TEST_CASE("edit: a subset has all that its Gaussians had") {
  Scene scene = random_scene(10, 2, 3);
  scene.antialiased = true;
  const Scene part = subset(scene, {7, 2});
  validate(part);
  CHECK(part.size() == 2);
  CHECK(part.sh_degree == 2);
  CHECK(part.antialiased);
  CHECK(part.means[0] == scene.means[7]);
  CHECK(part.scales[1] == scene.scales[2]);
  CHECK(part.rotations[0] == scene.rotations[7]);
  CHECK(part.opacities[1] == scene.opacities[2]);
  CHECK(part.sh0[0] == scene.sh0[7]);
  CHECK(part.sh_rest.size() == 48);
  CHECK(part.sh_rest[0] == scene.sh_rest[7 * 24]);
  CHECK(part.sh_rest[24 + 23] == scene.sh_rest[2 * 24 + 23]);
  CHECK(subset(scene, {}).size() == 0);
  CHECK_THROWS_AS(subset(scene, {10}), std::invalid_argument);
}

TEST_CASE("edit: a predicate selects in order") {
  const Scene scene = line(5);
  CHECK(select(scene, [](std::size_t i) { return i % 2 == 0; }) == Indices{0, 2, 4});
  CHECK(select(scene, [&](std::size_t i) { return scene.means[i].x > 9; }).empty());
}

TEST_CASE("edit: regions keep the Gaussians whose means lie in them, borders included") {
  const Scene scene = line(10);
  const auto places = [](const Scene& part) {
    std::vector<float> x;
    for (const vec3& mean : part.means) x.push_back(mean.x);
    return x;
  };
  CHECK(places(crop(scene, Box{dvec3(2, -1, -1), dvec3(4, 1, 1)})) == std::vector<float>{2, 3, 4});
  CHECK(places(crop(scene, Box{dvec3(-infinity), dvec3(1, infinity, infinity)})) == std::vector<float>{0, 1});
  CHECK(places(crop(scene, Sphere{dvec3(5, 0, 0), 1})) == std::vector<float>{4, 5, 6});
  CHECK(places(crop(scene, Sphere{dvec3(5, 0, 0.5), 0.25})).empty());
  CHECK(places(crop(scene, HalfSpace{dvec3(-2, 0, 0), -4})) == std::vector<float>{0, 1, 2});
  Scene hidden = scene;
  hidden.means[3].y = std::numeric_limits<float>::quiet_NaN();
  CHECK(crop(hidden, Box{dvec3(-infinity), dvec3(infinity)}).size() == 9);
}

TEST_CASE("edit: regions have the same borders along every axis") {
  for (int axis = 0; axis < 3; ++axis) {
    CAPTURE(axis);
    Scene scene = line(10);
    for (vec3& mean : scene.means) std::swap(mean.x, mean[axis]);
    const auto places = [&](const Scene& part) {
      std::vector<float> found;
      for (const vec3& mean : part.means) found.push_back(mean[axis]);
      return found;
    };
    const auto on_axis = [&](double at, double beside) {
      dvec3 p(beside);
      p[axis] = at;
      return p;
    };
    CHECK(places(crop(scene, Box{on_axis(2, -1), on_axis(4, 1)})) == std::vector<float>{2, 3, 4});
    CHECK(places(crop(scene, Box{on_axis(2, 0), on_axis(4, 0)})) == std::vector<float>{2, 3, 4});
    CHECK(places(crop(scene, Sphere{on_axis(5, 0), 1})) == std::vector<float>{4, 5, 6});
    CHECK(places(crop(scene, Sphere{on_axis(5, 3), std::sqrt(18.0) + 0.01})) == std::vector<float>{5});
    CHECK(places(crop(scene, HalfSpace{on_axis(-2, 0), -4})) == std::vector<float>{0, 1, 2});
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
  const Scene scene = random_scene(4, 2, 9);
  const Scene lower = with_degree(scene, 1), higher = with_degree(scene, 3);
  validate(lower), validate(higher);
  for (std::size_t i = 0; i < scene.size(); ++i)
    for (std::size_t k = 0; k < 45; ++k) {
      if (k < 9) CHECK(lower.sh_rest[9 * i + k] == scene.sh_rest[24 * i + k]);
      CHECK(higher.sh_rest[45 * i + k] == (k < 24 ? scene.sh_rest[24 * i + k] : 0));
    }
  CHECK(with_degree(scene, 0).sh_rest.empty());
  CHECK(with_degree(higher, 2).sh_rest == scene.sh_rest);
  for (const int degree : {-1, 4}) CHECK_THROWS_AS(with_degree(scene, degree), std::invalid_argument);
}

TEST_CASE("edit: scenes are joined in order, with the higher degree") {
  const Scene low = random_scene(3, 1, 1), high = random_scene(2, 3, 2);
  for (const bool low_first : {true, false}) {
    Scene all = low_first ? low : high;
    const Scene& more = low_first ? high : low;
    const std::size_t before = all.size();
    append(all, more);
    validate(all);
    CHECK(all.sh_degree == 3);
    CHECK(all.size() == 5);
    const Scene& first = low_first ? low : high;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const Scene& of = i < before ? first : more;
      const std::size_t k = i < before ? i : i - before;
      CHECK(all.means[i] == of.means[k]);
      CHECK(all.scales[i] == of.scales[k]);
      CHECK(all.rotations[i] == of.rotations[k]);
      CHECK(all.opacities[i] == of.opacities[k]);
      CHECK(all.sh0[i] == of.sh0[k]);
    }
    const std::size_t of_high = low_first ? 3 : 0, of_low = low_first ? 0 : 2;
    CHECK(all.sh_rest[45 * of_high + 44] == high.sh_rest[44]);
    CHECK(all.sh_rest[45 * of_low + 8] == low.sh_rest[8]);
    CHECK(all.sh_rest[45 * of_low + 9] == 0);
  }
  Scene twice = low;
  append(twice, twice);
  CHECK(twice.size() == 6);
  CHECK(twice.means[5] == low.means[2]);
}

TEST_CASE("edit: an antialiased scene is not joined with another") {
  Scene plain = random_scene(2, 0, 1), antialiased = random_scene(2, 0, 2), none;
  antialiased.antialiased = true;
  CHECK_THROWS_AS(append(plain, antialiased), std::invalid_argument);
  CHECK(plain.size() == 2);
  append(plain, none);
  CHECK_FALSE(plain.antialiased);
  append(none, antialiased);
  CHECK(none.antialiased);
  CHECK(none.size() == 2);
}
