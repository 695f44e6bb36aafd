// SPDX-License-Identifier: Apache-2.0
#include "bench/variants.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>

using namespace swiftgs;
using namespace swiftgs::cli;

namespace {

Scene one_gaussian() {
  Scene scene;
  scene.means = {vec3(1, 2, 3)};
  scene.scales = {vec3(0.1f, 0.4f, 0.2f)};
  scene.rotations = {{0.5f, 0.5f, 0.5f, 0.5f}};  // x to y, y to z, z to x
  scene.opacities = {0.7f};
  scene.sh0 = {vec3(0.1f, 0.2f, 0.3f)};
  return scene;
}

}  // namespace

TEST_CASE("bench variants: pieces have the mean and the variance of the whole") {
  for (const std::size_t count : {2, 3, 8}) {
    const Scene pieces = with_count(one_gaussian(), count, 1);
    REQUIRE(pieces.size() == count);
    validate(pieces);
    double mean = 0, variance = 0;
    for (std::size_t i = 0; i < count; ++i) {
      // The longest axis, y, points to z.
      CHECK(pieces.means[i].x == doctest::Approx(1));
      CHECK(pieces.means[i].y == doctest::Approx(2));
      CHECK(pieces.scales[i].x == 0.1f);
      CHECK(pieces.scales[i].z == 0.2f);
      CHECK(pieces.opacities[i] == 0.7f);
      mean += pieces.means[i].z / double(count);
      variance += double(pieces.scales[i].y) * pieces.scales[i].y / double(count);
    }
    for (std::size_t i = 0; i < count; ++i)
      variance += (pieces.means[i].z - mean) * (pieces.means[i].z - mean) / double(count);
    CAPTURE(count);
    CHECK(mean == doctest::Approx(3));
    CHECK(variance == doctest::Approx(0.16).epsilon(1e-5));
  }
}

TEST_CASE("bench variants: fewer are a part of the scene in its order and a seed repeats it") {
  const Scene scene = make_builtin_scene(1000), part = with_count(scene, 300, 7);
  REQUIRE(part.size() == 300);
  validate(part);
  const std::size_t rest = 3 * std::size_t(sh_rest_count(scene.sh_degree));
  std::size_t at = 0;
  for (std::size_t i = 0; i < part.size(); ++i, ++at) {
    while (at < scene.size() && scene.means[at] != part.means[i]) ++at;
    REQUIRE(at < scene.size());
    CHECK(scene.scales[at] == part.scales[i]);
    CHECK(scene.sh_rest[at * rest + 5] == part.sh_rest[i * rest + 5]);
  }
  CHECK(with_count(scene, 300, 7).means == part.means);
  CHECK(with_count(scene, 300, 8).means != part.means);
}

TEST_CASE("bench variants: any number can be asked for") {
  const Scene scene = make_builtin_scene(1000);
  for (const std::size_t count : {1, 999, 1000, 1001, 2500, 12000})
    CHECK(with_count(scene, count, 1).size() == count);
  CHECK_THROWS_AS(with_count(scene, 0, 1), std::invalid_argument);
  CHECK_THROWS_AS(with_count(Scene(), 5, 1), std::invalid_argument);
}

TEST_CASE("bench variants: enlarged Gaussians keep their places") {
  const Scene scene = enlarged(one_gaussian(), 3);
  CHECK(scene.scales[0].y == doctest::Approx(1.2));
  CHECK(scene.means[0] == vec3(1, 2, 3));
  for (const double wrong : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()})
    CHECK_THROWS_AS(enlarged(one_gaussian(), wrong), std::invalid_argument);
}
