// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>

using namespace swiftgs;

namespace {

/// Visits every number of `scene` in a fixed order.
template <class Visit>
void for_each_value(const Scene& scene, Visit visit) {
  for (std::size_t i = 0; i < scene.size(); ++i) {
    for (int c = 0; c < 3; ++c) visit(scene.means[i][c]), visit(scene.scales[i][c]), visit(scene.sh0[i][c]);
    const Quaternion& q = scene.rotations[i];
    visit(q.w), visit(q.x), visit(q.y), visit(q.z), visit(scene.opacities[i]);
  }
  for (float value : scene.sh_rest) visit(value);
}

/// The middle value of a quantity that `measure` gives for each Gaussian.
template <class Measure>
double quantile(const Scene& scene, double part, Measure measure) {
  std::vector<double> values;
  for (std::size_t i = 0; i < scene.size(); ++i) values.push_back(measure(i));
  std::sort(values.begin(), values.end());
  return values[std::size_t(part * double(values.size()))];
}

double longest(const Scene& scene, std::size_t i) {
  return std::max({scene.scales[i].x, scene.scales[i].y, scene.scales[i].z});
}
double shortest(const Scene& scene, std::size_t i) {
  return std::min({scene.scales[i].x, scene.scales[i].y, scene.scales[i].z});
}
double middle(const Scene& scene, std::size_t i) {
  return double(scene.scales[i].x) + double(scene.scales[i].y) + double(scene.scales[i].z) -
         longest(scene, i) - shortest(scene, i);
}

/// The part of the Gaussians for which `holds`.
template <class Holds>
double part_of(const Scene& scene, Holds holds) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < scene.size(); ++i) count += holds(i);
  return double(count) / double(scene.size());
}

const Scene& whole_scene() {
  static const Scene scene = make_builtin_scene();
  return scene;
}

}  // namespace

TEST_CASE("builtin scene: the same numbers on every machine") {
  std::uint64_t sum = 0;
  for_each_value(make_builtin_scene(1000), [&](float value) {
    // A sixty-fourth is coarse enough that a last bit cannot matter.
    sum = builtin::scramble(sum ^ std::uint64_t(std::int64_t(std::floor(64 * double(value) + 0.5))));
  });
  CHECK(sum == 17661560426421226664u);
}

TEST_CASE("builtin scene: two calls give the same bits") {
  const Scene a = make_builtin_scene(2000), b = make_builtin_scene(2000);
  CHECK(a.means == b.means);
  CHECK(a.scales == b.scales);
  CHECK(a.rotations == b.rotations);
  CHECK(a.opacities == b.opacities);
  CHECK(a.sh0 == b.sh0);
  CHECK(a.sh_rest == b.sh_rest);
}

TEST_CASE("builtin scene: any count is met exactly and every value is usable") {
  for (std::size_t count : {0, 1, 7, 100, 2001, 10'000}) {
    CAPTURE(count);
    const Scene scene = make_builtin_scene(count);
    CHECK(scene.size() == count);
    CHECK_NOTHROW(validate(scene));
    bool finite = true;
    for_each_value(scene, [&](float value) { finite = finite && std::isfinite(value); });
    CHECK(finite);
    bool valid = true;
    for (std::size_t i = 0; i < count; ++i) {
      const Quaternion& q = scene.rotations[i];
      valid = valid && std::abs(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z - 1) < 1e-6f;
      valid = valid && scene.opacities[i] > 0 && scene.opacities[i] < 1 && shortest(scene, i) > 0;
    }
    CHECK(valid);
  }
}

TEST_CASE("builtin scene: opacities are spread as in trained captures") {
  const Scene& scene = whole_scene();
  const double faint = part_of(scene, [&](std::size_t i) { return scene.opacities[i] < 0.1f; });
  const double clear = part_of(scene, [&](std::size_t i) { return scene.opacities[i] < 0.2f; });
  const double solid = part_of(scene, [&](std::size_t i) { return scene.opacities[i] > 0.9f; });
  CHECK(scene.size() == 200'000);
  CHECK(faint > 0.22);
  CHECK(faint < 0.35);
  CHECK(clear > 0.30);
  CHECK(clear < 0.48);
  CHECK(solid > 0.15);
  CHECK(solid < 0.45);
}

TEST_CASE("builtin scene: scales have a long tail with needles and flakes") {
  const Scene& scene = whole_scene();
  const auto size = [&](std::size_t i) { return std::log(longest(scene, i)); };
  CHECK(quantile(scene, 0.99, size) - quantile(scene, 0.5, size) > 4);
  CHECK(quantile(scene, 0.5, size) - quantile(scene, 0.01, size) > 1.5);
  const double needles =
      part_of(scene, [&](std::size_t i) { return longest(scene, i) > 20 * middle(scene, i); });
  const double flakes =
      part_of(scene, [&](std::size_t i) { return middle(scene, i) > 10 * shortest(scene, i); });
  CHECK(needles > 0.01);
  CHECK(flakes > 0.1);
  CHECK(quantile(scene, 0.5, [&](std::size_t i) { return longest(scene, i) / shortest(scene, i); }) > 8);
}

TEST_CASE("builtin scene: a tenth of the Gaussians is a far background") {
  const Scene& scene = whole_scene();
  const auto distance = [&](std::size_t i) { return builtin::length(dvec3(scene.means[i])); };
  CHECK(part_of(scene, [&](std::size_t i) { return distance(i) > 30; }) > 0.1);
  CHECK(part_of(scene, [&](std::size_t i) { return distance(i) < 3.5; }) > 0.6);
  CHECK(quantile(scene, 0.99999, distance) < 220);
}

TEST_CASE("builtin scene: colour depends on the viewing direction up to the third band") {
  const Scene& scene = whole_scene();
  CHECK(used_sh_degree(scene) == 3);
  for (std::size_t band = 1; band <= 3; ++band) {
    CAPTURE(band);
    const auto largest = [&](std::size_t i) {
      float value = 0;
      for (std::size_t k = 3 * (band * band - 1); k < 3 * ((band + 1) * (band + 1) - 1); ++k)
        value = std::max(value, std::abs(scene.sh_rest[45 * i + k]));
      return double(value);
    };
    CHECK(quantile(scene, 0.5, largest) > 0.02);
    CHECK(quantile(scene, 0.99, largest) > 0.2);
    CHECK(quantile(scene, 0.99999, largest) < 4);
  }
}

TEST_CASE("builtin scene: a surface of four times as many Gaussians has them half as large") {
  const Scene coarse = make_builtin_scene(10'000), fine = make_builtin_scene(40'000);
  // The terrace comes first.
  const auto typical = [](const Scene& scene) {
    std::vector<double> sizes;
    for (std::size_t i = 0; i < scene.size() / 5; ++i) sizes.push_back(middle(scene, i));
    std::sort(sizes.begin(), sizes.end());
    return sizes[sizes.size() / 2];
  };
  CHECK(typical(fine) / typical(coarse) == doctest::Approx(0.5).epsilon(0.03));
}

TEST_CASE("builtin scene: a lobe is the Legendre series that it is given") {
  builtin::Radiance radiance;
  const dvec3 towards = builtin::unit(dvec3(0.3, -0.8, 0.52));
  radiance.add_lobe(towards, {0.5, -0.25, 0.125, 2.0}, dvec3(1, 2, 0));
  // Seen along the axis every Legendre polynomial is 1.
  builtin::Radiance seen;
  seen.add_lobe(towards,
                {1.0 / 12.566370614359172, 3.0 / 12.566370614359172, 5.0 / 12.566370614359172,
                 7.0 / 12.566370614359172},
                dvec3(1.0));
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
