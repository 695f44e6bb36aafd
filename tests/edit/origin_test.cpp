// SPDX-License-Identifier: Apache-2.0
#include <limits>
#include <stdexcept>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/edit/all.hpp>
#include <swiftgs/tools/scene_part.hpp>

#include "policies/random_splats.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

const dvec3 earth(10'000'000, -6'378'137, 512'345);

/// The origin for positions `middle` + `size` * (-1/2 to 1/2).
dvec3 chosen(const dvec3& middle, double size, float scale = 0) {
  OriginChoice choice;
  OriginChoice::for_each_sample(101, [&](std::size_t i) {
    const double at = double(i) / 100 - 0.5;
    choice.add(middle + size * dvec3(at, at * at * at, -at), scale);
  });
  return choice.origin();
}

/// Means that a float holds exactly beside `earth`, and in a hundred times their scene's size from it.
Scene far_scene(std::size_t count) {
  Scene scene = random_scene(count, 2, 5);
  for (vec3& mean : scene.means) mean = glm::round(mean * 64.0f) / 64.0f;
  scene.origin = earth;
  return scene;
}

dvec3 place(const Scene& scene, std::size_t i) { return scene.origin + dvec3(scene.means[i]); }

}  // namespace

TEST_CASE("origin: positions far from zero for their size get the whole units in their middle") {
  CHECK(chosen({0.1, 0.2, 0.3}, 10) == dvec3(0));
  CHECK(chosen({10.1, -10.2, 0}, 10) == dvec3(0));
  CHECK(chosen({1000.1, -10.2, 0}, 10) == dvec3(1000, -10, 0));
  CHECK(chosen(earth + 0.25, 1000) == earth);
  CHECK(chosen({10'000.1, 0, 0}, 1000) == dvec3(10'000, 0, 0));
  // Powers of two below the size, in scenes smaller than 1.
  CHECK(chosen({1000.3, 0, 0}, 0.3) == dvec3(1000.25, 0, 0));
  CHECK(chosen({0.1, 0.2, 0.3}, 0) == dvec3(0.1, 0.2, 0.3));
  // What floats hold needs none, however far, and splats as large as the distance hide it.
  CHECK(chosen(earth, 0) == dvec3(0));
  CHECK(chosen({1000.1, -10.2, 0}, 10, 2000) == dvec3(0));
}

TEST_CASE("origin: one far Gaussian among many moves no origin away from them") {
  OriginChoice choice;
  for (int i = 0; i < 100; ++i) choice.add(earth + 0.01 * i, 0.001f);
  choice.add(earth + dvec3(300'000.7, 0, 0), 1);
  CHECK(glm::length(choice.origin() - earth) < 2);
}

TEST_CASE("origin: a thousandth of strays gives none and takes none away") {
  for (const std::size_t count : {6, 1000, 100'000}) {
    CAPTURE(count);
    const auto chosen_with = [&](const dvec3& middle, const dvec3& strays, float scale) {
      OriginChoice choice;
      OriginChoice::for_each_sample(count, [&](std::size_t i) {
        const double at = double(i) / double(count) - 0.5;
        const bool stray = i % 1000 == 3;
        choice.add(stray ? strays : middle + 10.0 * dvec3(at, at * at, -at) + 0.1, stray ? scale : 0.01f);
      });
      return choice.origin();
    };
    for (const float scale : {0.01f, 1e9f}) {
      CHECK(glm::length(chosen_with(earth, dvec3(0), scale) - earth) < 4);
      CHECK(glm::length(chosen_with(earth, earth + dvec3(4e6, 0, -1e7), scale) - earth) < 4);
      CHECK(chosen_with(dvec3(0), earth + 0.1, scale) == dvec3(0));
    }
  }
}

TEST_CASE("origin: numbers that float cannot hold have no say in it") {
  OriginChoice choice;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double bad : {1e300, -1e300, nan, std::numeric_limits<double>::infinity()})
    choice.add({bad, 0, 0}, 1);
  choice.add({1e6 + 0.1, 0, 0}, std::numeric_limits<float>::infinity());
  CHECK(choice.origin() == dvec3(0));
  choice.add({1e6 + 0.1, 0, 0}, 0.5f);
  CHECK(choice.origin() == dvec3(1e6, 0, 0));
}

TEST_CASE("origin: samples are even and all of what there are few") {
  std::vector<std::size_t> all;
  OriginChoice::for_each_sample(5, [&](std::size_t i) { all.push_back(i); });
  CHECK(all == std::vector<std::size_t>{0, 1, 2, 3, 4});
  all.clear();
  OriginChoice::for_each_sample(1'000'003, [&](std::size_t i) { all.push_back(i); });
  REQUIRE(all.size() == 4096);
  CHECK(all.front() == 0);
  CHECK(all.back() < 1'000'003);
  CHECK(all.back() > 999'000);
  for (std::size_t k = 1; k < all.size(); ++k) CHECK(all[k] - all[k - 1] - 244 <= 1);
}

TEST_CASE("origin: subsets and parts and orders and degrees keep it") {
  const Scene scene = far_scene(20);
  CHECK(subset(scene, {3, 4}).origin == earth);
  CHECK(part_of(scene, {1, 2}).origin == earth);
  CHECK(order_spatially(scene).origin == earth);
  CHECK(with_degree(scene, 1).origin == earth);
}

TEST_CASE("origin: regions are those of the world") {
  const Scene scene = far_scene(200);
  Scene near = scene;
  near.origin = dvec3(0);
  const auto same = [&](const Scene& a, const Scene& b) {
    CHECK(a.size() != 0);
    CHECK(a.size() != scene.size());
    CHECK(a.means == b.means);
  };
  same(crop(scene, Box{earth - 1.0, earth + 1.0}), crop(near, Box{dvec3(-1), dvec3(1)}));
  same(crop(scene, Sphere{earth, 1.5}), crop(near, Sphere{dvec3(0), 1.5}));
  same(crop(scene, HalfSpace{{1, 0, 0}, earth.x}), crop(near, HalfSpace{{1, 0, 0}, 0}));
}

TEST_CASE("origin: a scene with another origin is appended where it is") {
  Scene scene = far_scene(10);
  Scene other = far_scene(7);
  const dvec3 beside = earth + dvec3(3, -1, 0.5);
  other.origin = beside;
  append(scene, other);
  CHECK(scene.origin == earth);
  REQUIRE(scene.size() == 17);
  for (std::size_t i = 0; i < 7; ++i) CHECK(place(scene, 10 + i) == place(other, i));
  Scene empty;
  append(empty, other);
  CHECK(empty.origin == beside);
  append(empty, Scene());
  CHECK(empty.origin == beside);
}

TEST_CASE("origin: another one moves no Gaussian of the world") {
  const Scene scene = far_scene(10);
  const Scene moved = with_origin(scene, earth + dvec3(8, 0, -2));
  CHECK(moved.origin == earth + dvec3(8, 0, -2));
  for (std::size_t i = 0; i < scene.size(); ++i) CHECK(place(moved, i) == place(scene, i));
  CHECK_THROWS_WITH_AS(with_origin(scene, {0, 1e300, 0}),
                       doctest::Contains("expected finite numbers within the range of float"),
                       std::invalid_argument);
}

TEST_CASE("origin: movements of a scene far away round as those of one near by") {
  Scene scene = far_scene(30);
  const Scene before = scene;
  Similarity quarter;  // x to y, y to -x
  quarter.rotation[0] = {0, 1, 0}, quarter.rotation[1] = {-1, 0, 0}, quarter.scale = 2;
  quarter.translation = {100.25, 0, -3};
  transform(scene, quarter);
  CHECK(scene.origin != dvec3(0));
  for (std::size_t i = 0; i < scene.size(); ++i) CHECK(place(scene, i) == quarter(place(before, i)));

  Similarity back;
  back.translation = -earth;
  scene = before;
  transform(scene, back);
  CHECK(scene.origin == dvec3(0));
  CHECK(scene.means == before.means);
}

TEST_CASE("origin: a movement gives none to a scene that had none unless it is asked for") {
  Scene scene = far_scene(30);
  scene.origin = dvec3(0);
  const Scene before = scene;
  Similarity away;
  away.translation = earth + 0.125;
  Scene rounded = scene;
  transform(rounded, away);
  CHECK(rounded.origin == dvec3(0));
  const dvec3 origin = origin_for(scene, away);
  CHECK(origin != dvec3(0));
  transform(scene, away, origin);
  CHECK(scene.origin == origin);
  for (std::size_t i = 0; i < scene.size(); ++i)
    CHECK(place(scene, i) == place(before, i) + away.translation);
  CHECK(origin_for(before) == dvec3(0));
}

TEST_CASE("origin: one that no float can hold is refused") {
  Scene scene = far_scene(2);
  for (const double bad : {1e39, std::numeric_limits<double>::quiet_NaN()}) {
    scene.origin.y = bad;
    CHECK_THROWS_WITH_AS(validate(scene), doctest::Contains("scene: origin has "), std::invalid_argument);
  }
}
