// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstddef>
#include <utility>

#include <doctest/doctest.h>

#include "reference/gaussians.hpp"

namespace swiftgs::test {
namespace {

/// Checks alphas of a round Gaussian in the middle of the image.
void check_round(const ReferenceFrame& frame, double variance) {
  CHECK(worst_alpha(frame, [&](int x, int y) {
          const double d2 = (x - 16) * (x - 16) + (y - 16) * (y - 16);
          return unless_skipped(0.75 * std::exp(-0.5 * d2 / variance));
        }) < 1e-14);
  CHECK(alpha_at(frame, 16, 16) == 0.75);
}

TEST_CASE("reference: a round Gaussian on the axis has variance (f s / z)^2 + blur around its pixel") {
  check_round(draw(scene_of(Gaussian{.opacity = 0.75f})), std::pow(40 * double(0.1f) / 2, 2) + double(0.3f));
  Conventions k;
  for (const float blur : {0.1f, 0.3f, 4.0f}) {
    k.blur = blur;
    check_round(draw(scene_of(Gaussian{.scale = vec3(0), .opacity = 0.75f}), k), double(blur));
  }
}

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
  CHECK(gsplat.depth_at == Conventions::DepthAt::centre);
  CHECK(inria.depth_at == Conventions::DepthAt::centre);
}

/// A Gaussian at tangent `t` of one axis, deep in z only, seen with the principal point 8 pixels from the
/// first border of that axis; the alphas of the middle row or column, by the clamped tangent `limit`.
void check_clamp(double t, double limit, bool vertical, const Conventions& k) {
  Camera camera = small_camera(32, 32, 32);
  (vertical ? camera.cy : camera.cx) = 8;
  (vertical ? camera.cx : camera.cy) = 16.5;
  const vec3 mean = vertical ? vec3(0, float(t), 1) : vec3(float(t), 0, 1);
  Conventions alpha_footprint = k;
  alpha_footprint.footprint = Conventions::Footprint::alpha;
  const Scene scene = scene_of(Gaussian{.mean = mean, .scale = {0, 0, 0.5f}, .opacity = 0.75f});
  const ReferenceFrame frame = render_reference(scene, camera, alpha_footprint);
  const double variance = std::pow(32 * limit * 0.5, 2) + 0.3;
  double worst = 0, sum = 0;
  for (int i = 0; i < 32; ++i) {
    const double d = i + 0.5 - (32 * t + 8);
    const double alpha = vertical ? alpha_at(frame, 16, i) : alpha_at(frame, i, 16);
    worst = std::max(worst, std::abs(alpha - unless_skipped(0.75 * std::exp(-0.5 * d * d / variance))));
    sum += alpha;
  }
  CHECK(worst < 1e-6);  // the inputs are rounded to float
  CHECK(sum > 0.1);
}

TEST_CASE("reference: tangents are clamped 0.3 tan beyond each border or at 1.3 tan around the centre") {
  // tan = 32 / (2 * 32) = 0.5; borders at -8/32 and 24/32.
  const std::pair<double, double> around_image[] = {{1.2, 0.9}, {-0.7, -0.4}, {0.85, 0.85}, {-0.375, -0.375}};
  const std::pair<double, double> around_centre[] = {
      {1.2, 0.65}, {-0.7, -0.65}, {0.625, 0.625}, {-0.5, -0.5}};
  for (const bool vertical : {false, true}) {
    for (const auto& [t, limit] : around_image) check_clamp(t, limit, vertical, Conventions::gsplat());
    for (const auto& [t, limit] : around_centre) check_clamp(t, limit, vertical, Conventions::inria());
  }
}

TEST_CASE(
    "reference: antialiased mode scales opacity by the root of the determinants' ratio but not below a "
    "limit") {
  Conventions k;
  k.antialiased = true;
  const auto check_alpha = [&](const Gaussian& gaussian, double expected, double epsilon) {
    CHECK(alpha_at(draw(scene_of(gaussian), k), 16, 16) == doctest::Approx(expected).epsilon(epsilon));
  };
  const float s = 0.03125f;
  const double xx = std::pow(20 * double(s), 2), yy = 4 * xx, blur = double(0.3f);
  check_alpha({.scale = {s, 2 * s, s}, .opacity = 0.75f},
              0.75 * std::sqrt(xx * yy / ((xx + blur) * (yy + blur))), 1e-14);
  check_alpha({.scale = {1, 0, 0}, .opacity = 1.0f}, std::sqrt(double(2.5e-5f)), 1e-14);
  // 1e6 pixels long, 1 pixel wide, at 45 degrees: the products of its covariance are 1e24, their difference
  // 1e12.
  const Quaternion q{std::cos(0.39269908f), 0, 0, std::sin(0.39269908f)};
  check_alpha({.scale = {5e4f, 0.05f, 0}, .rotation = q, .opacity = 0.75f}, 0.75 * std::sqrt(1 / 1.3), 1e-6);
}

}  // namespace
}  // namespace swiftgs::test
