// SPDX-License-Identifier: Apache-2.0

// Margins of pixels; `oracle_test` checks the planes.
#include <cmath>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/reference.hpp>

#include "policies/random_splats.hpp"

namespace swiftgs::test {
namespace {

/// The middle pixel of an image before which balls of these depths and opacities lie.
struct Middle {
  explicit Middle(const std::vector<std::pair<float, float>>& balls, double stop = 0) {
    Scene scene;
    for (const auto& [depth, opacity] : balls) append(scene, vec3(0, 0, depth), 1, opacity);
    draw(scene, stop);
  }
  explicit Middle(const Scene& scene) { draw(scene, 0); }

  void draw(const Scene& scene, double stop) {
    Camera camera = forward_camera(3, 3);
    camera.cx = camera.cy = 1.5;
    Conventions conventions;
    conventions.alpha_max = 1, conventions.stop = float(stop), conventions.stop_at_equal = false;
    planes = render_reference_planes(scene, camera, conventions, 1);
  }
  double first_margin() const { return planes.first_margin[4]; }
  double median_margin() const { return planes.median_margin[4]; }
  double threshold_margin() const { return planes.threshold_margin[4]; }

  ReferencePlanes planes;
};

TEST_CASE("reference: margins tell the nearest transmittance and the next weight") {
  const Middle one({{2, 0.25f}, {3, 0.5f}, {4, 0.875f}});  // transmittances 0.75, 0.375 and 0.046875
  CHECK(one.planes.id[4] == 1);
  CHECK(one.planes.weight[4] == 0.375);
  CHECK(one.planes.next_weight[4] == 0.328125);
  CHECK(one.planes.depth_of_id[4] == 3);
  CHECK(one.median_margin() == 0.125);
  CHECK(one.first_margin() == doctest::Approx(0.2));  // of 0.95
  const Middle tie({{4, 1}, {2, 0.5f}});
  CHECK(tie.planes.id[4] == 1);
  CHECK(tie.planes.weight[4] == tie.planes.next_weight[4]);
  CHECK(tie.median_margin() == 0);
  const Middle none(Scene{});
  CHECK(none.planes.id[4] == no_gaussian);
  CHECK(std::isinf(none.median_margin()));
  CHECK(std::isinf(none.threshold_margin()));
}

TEST_CASE("reference: margins tell how near alphas and transmittances are to their thresholds") {
  CHECK(Middle({{2, 0.5f}}).threshold_margin() == doctest::Approx(126.5));
  CHECK(Middle({{2, 0.5f}, {3, 1.001f / 255}}).threshold_margin() == doctest::Approx(1e-3));
  CHECK(Middle({{2, 0.5f}, {3, 0.999f / 255}}).threshold_margin() >= 1e-3);  // drawn nowhere
  CHECK(Middle({{2, 0.5f}, {3, 0.5f}}, 0.2).threshold_margin() == doctest::Approx(0.25));
  CHECK(Middle({{2, 0.5f}, {3, 0.5f}}, 0.3).threshold_margin() == doctest::Approx(1 / 6.0));
}

TEST_CASE("reference: normals across the ray are undecided") {
  Scene scene;
  append(scene, vec3(0, 0, 2), 1, 0.5f), append(scene, vec3(0, 0, 3), 1, 0.5f);
  scene.scales[0] = vec3(0.1f, 1, 1);  // along x, across the ray through the middle
  scene.scales[1] = vec3(1, 1, 0.1f);
  const Middle across(scene);
  CHECK(across.planes.undecided_normals[4] == 0.5);
  CHECK(across.planes.normal[3 * 4 + 2] == -0.25);
  CHECK(std::abs(across.planes.normal[3 * 4]) == 0.5);
  scene.rotations[0] = {std::cos(1e-3f), 0, std::sin(1e-3f), 0};
  CHECK(Middle(scene).planes.undecided_normals[4] == 0);
}

}  // namespace
}  // namespace swiftgs::test
