// SPDX-License-Identifier: Apache-2.0

// The numbers of tests are the same whatever the compiler.
#include "policies/random_splats.hpp"

#include <doctest/doctest.h>

using namespace swiftgs;
using namespace swiftgs::test;

TEST_CASE("random splats: scenes and splats do not depend on the order in which arguments are evaluated") {
  const auto same = [](vec3 found, vec3 expected) {
    for (int c = 0; c < 3; ++c) CHECK(found[c] == doctest::Approx(expected[c]).epsilon(1e-5));
  };
  const Scene scene = random_scene(1, 0, 7);
  same(scene.means[0], vec3(2.92661405f, 4.94258976f, 8.71564674f));
  same(scene.scales[0], vec3(0.00619193632f, 0.00104595406f, 0.000311451033f));
  same(scene.sh0[0], vec3(0.1035477f, 0.056459967f, -0.28753975f));
  Random random(3);
  const SplatShape any = random_splat(random, 300, 200), usual = usual_splat(random, 300, 200);
  same(vec3(any.mean.x, any.mean.y, any.opacity), vec3(308.717468f, 281.686859f, 0.0423279665f));
  same(vec3(usual.mean.x, usual.mean.y, usual.opacity), vec3(132.259338f, 214.090973f, 0.00629672129f));
}
