// SPDX-License-Identifier: Apache-2.0
#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/edit.hpp>

#include "policies/backends.hpp"
#include "policies/tile_lists.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

SWIFTGS_CONTRACT("chunks: a scene with them has the same splats") {
  const auto scene = backend.upload(order_spatially(make_builtin_scene(30'000)));
  const SceneView with = scene.view();
  REQUIRE_FALSE(with.chunks.empty());
  SceneView without = with;
  without.chunks = {};
  Random random(1);
  for (int round = 0; round < 10; ++round) {
    Camera camera = forward_camera(160, 112, 160 * random.scale(0.3, 6));
    camera.translation = dvec3(random.in(-2, 2), random.in(-2, 2), random.in(-2, 2));
    const auto project_view = [&](const SceneView& of) {
      ProjectScratch<B> scratch;
      Splats<B> splats;
      Footprints<B> footprints;
      const OneView frame(camera, Conventions::gsplat(), of);
      project(backend, frame.plan(), Ellipse(), scratch, splats, footprints);
      bin(backend, frame.plan(), Ellipse(), splats, footprints);
      return to_host(backend, splats.view());
    };
    const SplatSet some = project_view(with), all = project_view(without);
    CHECK(same_bits(some.gaussians, all.gaussians));
    CHECK(same_bits(some.depths, all.depths));
    CHECK(same_bits(some.shapes, all.shapes));
  }
}
