// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <utility>

#include <doctest/doctest.h>

#include "reference/gaussians.hpp"

namespace swiftgs::test {
namespace {

TEST_CASE("reference: a local axis points where the quaternion turns it, w first") {
  // 30 degrees about +z take +x towards +y, which is down in the image.
  const double angle = std::acos(-1.0) / 6;
  const Quaternion q{float(std::cos(angle / 2)), 0, 0, float(std::sin(angle / 2))};
  const Scene scene = scene_of(Gaussian{.scale = {0.2f, 0.05f, 0.1f}, .rotation = q, .opacity = 0.75f});
  const ReferenceFrame frame = draw(scene);
  const double along = std::pow(20 * 0.2, 2) + 0.3, across = std::pow(20 * 0.05, 2) + 0.3;
  CHECK(worst_alpha(frame, [&](int x, int y) {
          const double u = std::cos(angle) * (x - 16) + std::sin(angle) * (y - 16);
          const double v = -std::sin(angle) * (x - 16) + std::cos(angle) * (y - 16);
          return unless_skipped(0.75 * std::exp(-0.5 * (u * u / along + v * v / across)));
        }) < 1e-6);  // the inputs are rounded to float
}

TEST_CASE("reference: means and covariances follow the camera's pose and focal lengths") {
  // The camera stands at (5, 1, 0) and looks along -x: image x is world z, image y is world y.
  Camera camera = small_camera();
  camera.rotation = dmat3(dvec3(0, 0, -1), dvec3(0, 1, 0), dvec3(1, 0, 0));
  camera.translation = dvec3(0, -1, 5);
  camera.fx = 32, camera.fy = 64, camera.cx = 10.25, camera.cy = 20.5;
  const Gaussian g{.mean = {1, 1.25f, 0.5f}, .scale = {0, 0.125f, 0.25f}, .opacity = 0.75f};
  const ReferenceFrame frame = render_reference(scene_of(g), camera, Conventions::gsplat());
  const double mean_x = 32 * 0.5 / 4 + 10.25, mean_y = 64 * 0.25 / 4 + 20.5;
  const double xx = 2.0 * 2.0 + double(0.3f), yy = 2.0 * 2.0 + double(0.3f);
  CHECK(worst_alpha(frame, [&](int x, int y) {
          const double dx = x + 0.5 - mean_x, dy = y + 0.5 - mean_y;
          return unless_skipped(0.75 * std::exp(-0.5 * (dx * dx / xx + dy * dy / yy)));
        }) < 1e-14);
  CHECK(frame.depth[at(frame, 14, 24)] == doctest::Approx(4).epsilon(1e-14));
}

TEST_CASE("reference: presets have their planes and footprints") {
  const Conventions gsplat = Conventions::gsplat(), inria = Conventions::inria();
  CHECK(std::pair{gsplat.near_plane, gsplat.far_plane} == std::pair{0.01f, 1e10f});
  CHECK(inria.near_plane == 0.2f);
  CHECK(std::isinf(inria.far_plane));
  CHECK_FALSE(gsplat.cull_at_near);
  CHECK(inria.cull_at_near);
  CHECK(gsplat.footprint == Conventions::Footprint::alpha);
  CHECK(inria.footprint == Conventions::Footprint::three_sigma_square);
  CHECK(Conventions::khronos().footprint == Conventions::Footprint::three_sigma_ellipse);
  for (const Conventions& preset : {gsplat, inria, Conventions::khronos()})
    CHECK(preset.depth_at == Conventions::DepthAt::centre);
}

}  // namespace
}  // namespace swiftgs::test
