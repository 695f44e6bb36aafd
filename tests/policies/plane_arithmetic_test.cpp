// SPDX-License-Identifier: Apache-2.0

// Shapes whose normals and depths along the ray frames leave undecided.
#include <doctest/doctest.h>

#include <swiftgs/plane/attribute_stage.hpp>
#include <swiftgs/plane/attributes.hpp>

#include "policies/random_splats.hpp"

namespace swiftgs::test::plane_arithmetic_test {

TEST_CASE("planes: of equally short axes the first is a normal") {
  CHECK(shortest_axis(vec3(1, 1, 1)) == 0);
  CHECK(shortest_axis(vec3(2, 1, 1)) == 1);
  CHECK(shortest_axis(vec3(1, 2, 1)) == 0);
  CHECK(shortest_axis(vec3(2, 2, 1)) == 2);
  CHECK(shortest_axis(vec3(3, 2, 1)) == 2);
  CHECK(shortest_axis(vec3(2, 1, 3)) == 1);
}

TEST_CASE("planes: depth along the ray does not slope where its square could not be summed or nothing fits") {
  Scene scene;
  append(scene, vec3(0.5f, 0, 2), 0.1f, 0.5f);
  scene.scales[0].x = 0;
  scene.rotations[0] = {0.9238795f, 0, 0.3826834f, 0};  // the card is z = x + 1.5
  Camera camera = forward_camera(64, 48, 100);
  camera.lens.model = LensModel::orthographic;
  Conventions conventions;
  const auto depth = [&](float most_squared) {
    const vec2 mean(float(0.5 * camera.fx + camera.cx), float(camera.cy));
    return ray_depth(view_constants(camera, conventions), gaussian(view(scene), 0), mean, 2, most_squared);
  };
  conventions.blur = 0;
  CHECK(depth(1e38f).x == doctest::Approx(0.01));
  CHECK(depth(4).x == 0);
  CHECK(depth(4).middle == 2);
  scene.scales[0] = vec3(0);
  for (const float blur : {0.5f, 0.0f}) {
    conventions.blur = blur;
    CHECK(depth(1e38f).x == 0);
    CHECK(depth(1e38f).middle == 2);
  }
}

}  // namespace swiftgs::test::plane_arithmetic_test
