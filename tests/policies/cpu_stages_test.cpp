// SPDX-License-Identifier: Apache-2.0

// Vector projection and shading against the scalar forms, member by member. tests/stability compares both
// with exact values, on Gaussians that are hard for float.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>

#include <doctest/doctest.h>

#include <swiftgs/project/sh.hpp>

#include "policies/random_splats.hpp"
#include "stability/targets.hpp"
#include "stability/ulps.hpp"

namespace swiftgs::test::cpu_stages_test {

namespace {

/// What a member of a splat may differ by in ulps.
struct Limit {
  double usual;
  double compensated;  ///< where anti-aliasing compensates opacities
};

/// Limits on Gaussians of usual shapes, needles and flakes among them. Behind each is the largest difference
/// measured. Means and depths come from double and round to the same float.
struct Member {
  const char* name;
  Limit fused;    ///< of targets that fuse multiplications and additions, as the scalar form does
  Limit unfused;  ///< of others
};
constexpr Member members[] = {
    {"mean", {1, 1}, {1, 1}},         // 0; 0
    {"l0", {2, 2}, {24, 24}},         // 1; 17, of the minors of a flake that is seen edge-on
    {"l1", {3, 3}, {28, 28}},         // 2; 22, has the digits of l0
    {"l2", {1, 1}, {9, 9}},           // 0; 7
    {"opacity", {0, 0}, {0, 16}},     // 0; 11, by the root of the minors' sum over the variance in l0
    {"cutoff", {1.5, 3}, {1.5, 12}},  // 1 and 2; 1 and 8, of the logarithm, and of such an opacity
    {"depth", {1, 1}, {1, 1}}};       // 0; 0
using Apart = std::array<double, std::size(members)>;
/// The same through lenses.
constexpr Apart through_lens = {1, 160, 160, 2 * 60, 160, 160, 1};

double apart(float a, float b, double scale = 0) {
  return double(std::abs(Real(a) - Real(b)) /
                ulp(std::max({std::abs(Real(a)), std::abs(Real(b)), Real(scale)})));
}

/// Differences in ulps.
Apart differences(const SplatShape& a, float depth_a, const SplatShape& b, float depth_b) {
  // Of l1, what l0 dx is at the edge of the splat: l0 times its width over its height.
  const double l1_scale =
      double(a.l0) * double(a.l2) * double(EllipseExtent(a).width) / std::sqrt(double(a.cutoff));
  const auto means_apart = [&](int k) {
    return std::max(apart(a.mean[k], b.mean[k], 1), std::abs(a.exact_mean()[k] - b.exact_mean()[k]) * 0x1p23);
  };
  return {std::max(means_apart(0), means_apart(1)),
          apart(a.l0, b.l0),
          apart(a.l1, b.l1, l1_scale),
          apart(a.l2, b.l2),
          apart(a.opacity, b.opacity),
          apart(a.cutoff, b.cutoff, 1),
          apart(depth_a, depth_b)};
}

/// A camera that sees much of what `forward_camera` sees, from another place and turned.
Camera turned_camera() {
  Camera camera = forward_camera(640, 480);
  const double cp = std::cos(0.1), sp = std::sin(0.1), cy = std::cos(0.2), sy = std::sin(0.2);
  camera.rotation[0] = dvec3(cy, sp * sy, -cp * sy);
  camera.rotation[1] = dvec3(0, cp, sp);
  camera.rotation[2] = dvec3(sy, -sp * cy, cp * cy);
  camera.translation = dvec3(0.3, -0.2, 0.4);
  return camera;
}

/// Calls f(target, scalar, found) with what the scalar form and each vector target make of `scene`.
template <class F>
void for_each_target(Targets& targets, const View& view, const Scene& scene, const F& f) {
  Projected scalar, found;
  targets.on(0, [&](auto& backend) { scalar = project_to_host(backend, view, scene); });
  for (std::size_t t = 1; t < targets.size(); ++t) {
    const std::string name = targets.name(t);
    CAPTURE(name);
    targets.on(t, [&](auto& backend) { found = project_to_host(backend, view, scene); });
    f(name, scalar, found);
  }
}

/// Calls f(a, b) with the places of each splat that both have. Returns how many only one has.
template <class F>
std::size_t for_each_shared(const Projected& x, const Projected& y, const F& f) {
  std::size_t a = 0, b = 0, alone = 0;
  while (a < x.gaussians.size() && b < y.gaussians.size()) {
    if (x.gaussians[a] == y.gaussians[b])
      f(a++, b++);
    else
      ++alone, x.gaussians[a] < y.gaussians[b] ? ++a : ++b;
  }
  return alone + x.gaussians.size() - a + y.gaussians.size() - b;
}

/// Checks that members of splats that both have differ by limit_of(member) at most, and that `most_alone`
/// splats at most are in one of them only.
template <class LimitOf>
void check_splats(const Projected& x, const Projected& y, std::size_t most_alone, const LimitOf& limit_of) {
  Apart worst{};
  const std::size_t alone = for_each_shared(x, y, [&](std::size_t a, std::size_t b) {
    const Apart here = differences(x.shapes[a], x.depths[a], y.shapes[b], y.depths[b]);
    for (std::size_t k = 0; k < here.size(); ++k) worst[k] = std::max(worst[k], here[k]);
  });
  for (std::size_t k = 0; k < worst.size(); ++k) {
    CAPTURE(members[k].name);
    CHECK(worst[k] <= limit_of(k));
  }
  CHECK(alone <= most_alone);
}

View whole(const Camera& camera, const Conventions& conventions = {}) {
  return make_view(camera, conventions, {.width = camera.width, .height = camera.height});
}

}  // namespace

TEST_CASE("cpu stages: every vector target projects to the scalar splats within a few ulps") {
  const Scene scene = random_scene(40000, 0, 61);
  Targets targets;
  Conventions compensated;
  compensated.antialiased = true;
  for (const Camera& camera : {forward_camera(640, 480), turned_camera()})
    for (const Conventions& conventions : {Conventions::gsplat(), Conventions::inria(), compensated})
      for_each_target(targets, whole(camera, conventions), scene,
                      [&](const std::string& name, const Projected& scalar, const Projected& found) {
                        REQUIRE(scalar.shapes.size() > 10000);
                        const bool fuses =
                            name.find("SSE") == std::string::npos && name.find("EMU") == std::string::npos;
                        // One alone may be at the border of the image; none was measured.
                        check_splats(scalar, found, 1, [&](std::size_t member) {
                          const Limit limit = fuses ? members[member].fused : members[member].unfused;
                          return conventions.antialiased ? limit.compensated : limit.usual;
                        });
                      });
}

TEST_CASE("cpu stages: every vector target projects needles through lenses as the scalar form does") {
  // Long and thin, towards the camera as well.
  Scene scene = random_scene(20000, 0, 62);
  for (std::size_t i = 0; i < scene.size(); i += 3) scene.scales[i] *= vec3(1, 1, 300);
  Camera distorted = forward_camera(640, 480), fisheye = distorted, tele = distorted, panorama = distorted;
  distorted.lens.distortion = {{-0.12, 0.03, -0.002, 0}, {0.01, 0.002, 0}, {0.004, -0.003}, {}};
  fisheye.lens.model = tele.lens.model = LensModel::fisheye;
  fisheye.fx = fisheye.fy = 200, tele.fx = tele.fy = 2000;
  tele.width = tele.height = 4096, tele.cx = tele.cy = 2048;
  fisheye.lens.distortion = {{0.03, -0.004, 0.0005, 0}, {}, {}, {-0.003, 0.002}};
  panorama.lens.model = LensModel::equirectangular;
  panorama.fx = panorama.fy = panorama.width / 6.28;
  Conventions compensated;
  compensated.antialiased = true;
  Targets targets;
  for (const Camera& camera : {distorted, fisheye, tele, panorama}) {
    CAPTURE(name_of(camera.lens.model));
    for_each_target(targets, whole(camera, compensated), scene,
                    [&](const std::string&, const Projected& scalar, const Projected& found) {
                      REQUIRE(scalar.shapes.size() > 500);
                      check_splats(scalar, found, 2, [](std::size_t member) { return through_lens[member]; });
                    });
  }
}

TEST_CASE(
    "cpu stages: every vector target finds the splats of a part of an image that the scalar form finds") {
  const Scene scene = random_scene(40000, 0, 64);
  Targets targets;
  for (const Camera& camera : {forward_camera(640, 480), turned_camera()}) {
    const View view = make_view(camera, Conventions(), {.width = 300, .height = 201}, vec3(0), {160, 112});
    for_each_target(targets, view, scene,
                    [](const std::string&, const Projected& scalar, const Projected& found) {
                      REQUIRE(scalar.gaussians.size() > 1000);
                      REQUIRE(scalar.gaussians.size() < 30000);
                      CHECK(for_each_shared(scalar, found, [](std::size_t, std::size_t) {}) <=
                            1);  // at the border of the part
                    });
  }
}

TEST_CASE("cpu stages: every vector target shades to the scalar colours within a few ulps") {
  Targets targets;
  for (int degree = 0; degree <= max_sh_degree; ++degree)
    for (const Camera& camera : {forward_camera(640, 480), turned_camera()}) {
      CAPTURE(degree);
      const Scene scene = random_scene(20000, degree, 62);
      const View view = whole(camera);
      const std::size_t count = std::size_t(sh_rest_count(degree));
      for_each_target(
          targets, view, scene, [&](const std::string&, const Projected& scalar, const Projected& found) {
            double worst = 0;
            std::size_t compared = 0;
            for_each_shared(scalar, found, [&](std::size_t a, std::size_t b) {
              ++compared;
              const std::uint32_t id = scalar.gaussians[a];
              // In ulps of the sum of the terms' magnitudes: terms may cancel.
              float basis[sh_rest_count(max_sh_degree)];
              sh_basis(degree, view_direction(view.camera, scene.means[id]), basis);
              for (int c = 0; c < 3; ++c) {
                double terms = 0.5 + 0.2821 * double(std::abs(scene.sh0[id][c]));
                for (std::size_t k = 0; k < count; ++k)
                  terms += double(std::abs(basis[k] * scene.sh_rest[3 * (id * count + k) + std::size_t(c)]));
                const float difference = scalar.colours[a].rgb[c] - found.colours[b].rgb[c];
                worst = std::max(worst, double(std::abs(difference)) / double(ulp(terms)));
              }
            });
            REQUIRE(compared > 5000);
            CHECK(worst <= 5);  // 4 with bands 2 and 3, 2 with band 1: sums in another order
          });
    }
}

}  // namespace swiftgs::test::cpu_stages_test
