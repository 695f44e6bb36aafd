// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include <doctest/doctest.h>
#include <sys/mman.h>
#include <unistd.h>

#include "reference/gaussians.hpp"

namespace swiftgs::test {
namespace {

TEST_CASE("reference: a round Gaussian on the axis has variance (f s / z)^2 + blur around its pixel") {
  const float s = 0.1f;
  const ReferenceFrame frame =
      render_reference(scene_of(Gaussian{.opacity = 0.75f}), small_camera(), Conventions::gsplat());
  const double variance = std::pow(40 * double(s) / 2, 2) + double(0.3f);
  CHECK(worst_alpha(frame, [&](int x, int y) {
          const double d2 = (x - 16) * (x - 16) + (y - 16) * (y - 16);
          return unless_skipped(0.75 * std::exp(-0.5 * d2 / variance));
        }) < 1e-14);
  CHECK(alpha_at(frame, 16, 16) == 0.75);
}

TEST_CASE("reference: a Gaussian without extent is as wide as the blur") {
  Conventions k;
  for (const float blur : {0.1f, 0.3f, 4.0f}) {
    k.blur = blur;
    const Scene scene = scene_of(Gaussian{.scale = vec3(0), .opacity = 0.75f});
    CHECK(worst_alpha(render_reference(scene, small_camera(), k), [&](int x, int y) {
            const double d2 = (x - 16) * (x - 16) + (y - 16) * (y - 16);
            return unless_skipped(0.75 * std::exp(-0.5 * d2 / double(blur)));
          }) < 1e-14);
  }
}

TEST_CASE("reference: scales of a Gaussian that the planes cull are not read") {
  // Whole pages of scales belong to Gaussians behind the camera. A read of them ends the program.
  const std::size_t page = std::size_t(sysconf(_SC_PAGESIZE)), count = page;
  Scene scene;
  scene.means.assign(count, vec3(0, 0, 2)), scene.scales.assign(count, vec3(0.1f));
  scene.rotations.resize(count), scene.opacities.assign(count, 0.01f), scene.sh0.resize(count);
  const auto begin = reinterpret_cast<std::uintptr_t>(scene.scales.data());
  const std::uintptr_t first = (begin + page - 1) / page * page, last = first + 10 * page;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uintptr_t at = begin + i * sizeof(vec3);
    if (at + sizeof(vec3) > first && at < last) scene.means[i].z = -2;
  }
  const ReferenceFrame all = render_reference(scene, small_camera(), Conventions::gsplat());
  REQUIRE(mprotect(reinterpret_cast<void*>(first), 10 * page, PROT_NONE) == 0);
  const ReferenceFrame guarded = render_reference(scene, small_camera(), Conventions::gsplat());
  REQUIRE(mprotect(reinterpret_cast<void*>(first), 10 * page, PROT_READ | PROT_WRITE) == 0);
  CHECK(guarded.contributing_pairs > 0);
  CHECK(guarded.colour == all.colour);
}

TEST_CASE("reference: without blur a Gaussian without extent covers nothing and is culled") {
  Conventions k;
  k.blur = 0;
  const Scene scene = scene_of(Gaussian{.scale = vec3(0)}, Gaussian{.scale = vec3(1, 0, 0)});
  CHECK(render_reference(scene, small_camera(), k).contributing_pairs == 0);
}

TEST_CASE("reference: a local axis points where the quaternion turns it, w first") {
  // 30 degrees about +z take +x towards +y, which is down in the image.
  const double angle = std::acos(-1.0) / 6;
  const Quaternion q{float(std::cos(angle / 2)), 0, 0, float(std::sin(angle / 2))};
  const Scene scene = scene_of(Gaussian{.scale = {0.2f, 0.05f, 0.1f}, .rotation = q, .opacity = 0.75f});
  const ReferenceFrame frame = render_reference(scene, small_camera(), Conventions::gsplat());
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

TEST_CASE("reference: the near plane keeps an equal depth for gsplat and culls it for inria") {
  const auto drawn = [](float z, const Conventions& k) {
    const Scene scene = scene_of(Gaussian{.mean = {0, 0, z}, .scale = vec3(0.001f)});
    return render_reference(scene, small_camera(), k).visible == 1;
  };
  const float below = 0;
  CHECK(drawn(0.01f, Conventions::gsplat()));
  CHECK_FALSE(drawn(std::nextafter(0.01f, below), Conventions::gsplat()));
  CHECK_FALSE(drawn(0.2f, Conventions::inria()));
  CHECK(drawn(std::nextafter(0.2f, 1.0f), Conventions::inria()));
  CHECK_FALSE(drawn(-1, Conventions::gsplat()));
}

TEST_CASE("reference: the far plane culls what is beyond it and inria has none") {
  const auto drawn = [](float z, const Conventions& k) {
    return render_reference(scene_of(Gaussian{.mean = {0, 0, z}}), small_camera(), k).visible == 1;
  };
  CHECK(drawn(1e10f, Conventions::gsplat()));
  CHECK_FALSE(drawn(std::nextafter(1e10f, 2e10f), Conventions::gsplat()));
  CHECK(drawn(3e38f, Conventions::inria()));
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

TEST_CASE("reference: around_image clamps tangents 0.3 tan beyond each border") {
  // tan = 32 / (2 * 32) = 0.5; borders at -8/32 and 24/32.
  for (const bool vertical : {false, true}) {
    check_clamp(1.2, 0.75 + 0.15, vertical, Conventions::gsplat());
    check_clamp(-0.7, -(0.25 + 0.15), vertical, Conventions::gsplat());
    check_clamp(0.85, 0.85, vertical, Conventions::gsplat());
    check_clamp(-0.375, -0.375, vertical, Conventions::gsplat());
  }
}

TEST_CASE("reference: around_centre clamps tangents at 1.3 tan wherever the principal point is") {
  for (const bool vertical : {false, true}) {
    check_clamp(1.2, 0.65, vertical, Conventions::inria());
    check_clamp(-0.7, -0.65, vertical, Conventions::inria());
    check_clamp(0.625, 0.625, vertical, Conventions::inria());
    check_clamp(-0.5, -0.5, vertical, Conventions::inria());
  }
}

TEST_CASE("reference: antialiased mode scales opacity by the root of the determinants' ratio") {
  Conventions k;
  k.antialiased = true;
  const float s = 0.03125f;
  const Scene scene = scene_of(Gaussian{.scale = {s, 2 * s, s}, .opacity = 0.75f});
  const double xx = std::pow(20 * double(s), 2), yy = 4 * xx, blur = double(0.3f);
  const double factor = std::sqrt(xx * yy / ((xx + blur) * (yy + blur)));
  CHECK(alpha_at(render_reference(scene, small_camera(), k), 16, 16) ==
        doctest::Approx(0.75 * factor).epsilon(1e-14));
}

TEST_CASE("reference: antialiased mode never scales opacity below the root of min_compensation") {
  Conventions k;
  k.antialiased = true;
  const Scene scene = scene_of(Gaussian{.scale = {1, 0, 0}, .opacity = 1.0f});
  CHECK(alpha_at(render_reference(scene, small_camera(), k), 16, 16) ==
        doctest::Approx(std::sqrt(double(2.5e-5f))).epsilon(1e-14));
}

TEST_CASE("reference: antialiased mode keeps the ratio of a needle whose determinant would cancel") {
  // 1e6 pixels long, 1 pixel wide, at 45 degrees: the products of its covariance are 1e24, their difference
  // 1e12.
  Conventions k;
  k.antialiased = true;
  const Quaternion q{std::cos(0.39269908f), 0, 0, std::sin(0.39269908f)};
  const Scene scene = scene_of(Gaussian{.scale = {5e4f, 0.05f, 0}, .rotation = q, .opacity = 0.75f});
  const double factor = std::sqrt(1 / 1.3);
  CHECK(alpha_at(render_reference(scene, small_camera(), k), 16, 16) ==
        doctest::Approx(0.75 * factor).epsilon(1e-6));
}

}  // namespace
}  // namespace swiftgs::test
