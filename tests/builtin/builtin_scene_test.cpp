// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>

#include "arithmetic.hpp"
#include "light.hpp"

using namespace swiftgs;

namespace {

/// Every number of `scene` in a fixed order.
std::vector<float> values_of(const Scene& scene) {
  std::vector<float> out;
  for (std::size_t i = 0; i < scene.size(); ++i) {
    for (int c = 0; c < 3; ++c)
      out.insert(out.end(), {scene.means[i][c], scene.scales[i][c], scene.sh0[i][c]});
    const Quaternion& q = scene.rotations[i];
    out.insert(out.end(), {q.w, q.x, q.y, q.z, scene.opacities[i]});
  }
  out.insert(out.end(), scene.sh_rest.begin(), scene.sh_rest.end());
  return out;
}

float shortest(const Scene& scene, std::size_t i) {
  return std::min({scene.scales[i].x, scene.scales[i].y, scene.scales[i].z});
}
/// Of the three scales.
float middle(const Scene& scene, std::size_t i) {
  const vec3& s = scene.scales[i];
  return std::max(std::min(s.x, s.y), std::min(std::max(s.x, s.y), s.z));
}

}  // namespace

TEST_CASE("builtin scene: the same numbers on every machine") {
  std::uint64_t sum = 0;
  for (const float value : values_of(make_builtin_scene(1000)))
    // A sixty-fourth is coarse enough that a last bit cannot matter.
    sum = builtin::scramble(sum ^ std::uint64_t(std::int64_t(std::floor(64 * double(value) + 0.5))));
  CHECK(sum == 17661560426421226664u);
  CHECK(make_builtin_scene().size() == 200'000);
}

TEST_CASE("builtin scene: any count is met exactly and every value is usable and the same in two calls") {
  for (std::size_t count : {0, 1, 7, 100, 2001, 10'000}) {
    CAPTURE(count);
    const Scene scene = make_builtin_scene(count);
    CHECK(scene.size() == count);
    CHECK_NOTHROW(validate(scene));
    const std::vector<float> values = values_of(scene);
    CHECK(std::all_of(values.begin(), values.end(), [](float value) { return std::isfinite(value); }));
    CHECK((values_of(make_builtin_scene(count)) == values));
    bool valid = true;
    for (std::size_t i = 0; i < count; ++i) {
      const Quaternion& q = scene.rotations[i];
      valid = valid && std::abs(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z - 1) < 1e-6f;
      valid = valid && scene.opacities[i] > 0 && scene.opacities[i] < 1 && shortest(scene, i) > 0;
    }
    CHECK(valid);
  }
}

TEST_CASE("builtin scene: a surface of four times as many Gaussians has them half as large") {
  const Scene coarse = make_builtin_scene(10'000), fine = make_builtin_scene(40'000);
  // The terrace comes first.
  const auto typical = [](const Scene& scene) {
    std::vector<float> sizes;
    for (std::size_t i = 0; i < scene.size() / 5; ++i) sizes.push_back(middle(scene, i));
    std::sort(sizes.begin(), sizes.end());
    return sizes[sizes.size() / 2];
  };
  CHECK(double(typical(fine) / typical(coarse)) == doctest::Approx(0.5).epsilon(0.03));
}

TEST_CASE("builtin scene: a lobe is the Legendre series that it is given") {
  builtin::Radiance radiance;
  const dvec3 towards = builtin::unit(dvec3(0.3, -0.8, 0.52));
  radiance.add_lobe(towards, {0.5, -0.25, 0.125, 2.0}, dvec3(1, 2, 0));
  // Seen along the axis every Legendre polynomial is 1.
  builtin::Radiance seen;
  const double sphere = 4 * std::acos(-1.0);
  seen.add_lobe(towards, {1 / sphere, 3 / sphere, 5 / sphere, 7 / sphere}, dvec3(1.0));
  dvec3 sum(0.0);
  for (std::size_t k = 0; k < 16; ++k) sum += radiance.coefficients[k] * seen.coefficients[k];
  CHECK(sum.x == doctest::Approx(2.375).epsilon(1e-9));
  CHECK(sum.y == doctest::Approx(4.75).epsilon(1e-9));
  CHECK(sum.z == 0);
}

TEST_CASE("builtin scene: its sine and power of two agree with the standard library") {
  for (double x = -3; x < 3; x += 0.0137) {
    CAPTURE(x);
    CHECK(builtin::sin_turns(x) == doctest::Approx(std::sin(6.283185307179586 * x)).epsilon(1e-8));
    CHECK(builtin::power_of_two(5 * x) / std::exp2(5 * x) == doctest::Approx(1).epsilon(1e-8));
  }
}

TEST_CASE("builtin cameras: all are valid and look at the still life from outside it") {
  const std::vector<Camera> cameras = builtin_cameras(24, 320, 180);
  REQUIRE(cameras.size() == 24);
  CHECK_NOTHROW(validate(builtin_camera()));
  for (const Camera& camera : cameras) {
    CAPTURE(camera.name);
    CHECK_NOTHROW(validate(camera));
    const dvec3 knot = camera.rotation * builtin::at(0, 1.1, 0) + camera.translation;
    CHECK(std::abs(knot.x / knot.z * camera.fx) < 20);
    CHECK(std::abs(knot.y / knot.z * camera.fy) < 90);
    CHECK(knot.z > 3);
  }
}
