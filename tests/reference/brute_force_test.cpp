// SPDX-License-Identifier: Apache-2.0
#include "reference/brute_force.hpp"

#include <cmath>
#include <cstdint>

#include <doctest/doctest.h>

#include <swiftgs/metrics.hpp>

#include "reference/gaussians.hpp"

namespace swiftgs::test {
namespace {

/// Numbers in [0, 1) that are the same on every machine.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  double operator()() {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return double(state_ >> 40) * 0x1p-24;
  }
  double between(double low, double high) { return low + (high - low) * (*this)(); }
  float between(float low, float high) { return float(between(double(low), double(high))); }

 private:
  std::uint64_t state_;
};

/// Gaussians in a box around the camera's near half space: dots, needles, flakes and giants, a few behind
/// the camera and near its plane, some with equal depths.
Scene random_scene(std::uint64_t seed, int count) {
  Random random(seed);
  Scene scene;
  for (int i = 0; i < count; ++i) {
    const float size = std::exp(random.between(-4.0f, -0.5f));
    const int shape = int(4 * random());
    vec3 scale(size);
    if (shape == 1) scale = vec3(8 * size, 0.02f * size, 0.02f * size);
    if (shape == 2) scale = vec3(2 * size, 2 * size, 0);
    if (shape == 3 && i % 5 == 0) scale = vec3(20 * size);
    Eigen::Quaterniond q(random() - 0.5, random() - 0.5, random() - 0.5, random() - 0.5);
    q.normalize();
    scene.scales.push_back(scale);
    scene.rotations.push_back({float(q.w()), float(q.x()), float(q.y()), float(q.z())});
    scene.means.push_back({random.between(-2.0f, 2.0f), random.between(-2.0f, 2.0f),
                           i % 7 == 0 ? 1.5f : random.between(-0.5f, 4.0f)});
    scene.opacities.push_back(random.between(0.0f, 1.0f));
    scene.sh0.push_back(
        {random.between(-3.0f, 3.0f), random.between(-3.0f, 3.0f), random.between(-3.0f, 3.0f)});
  }
  return scene;
}

Camera off_centre_camera() {
  Camera camera = small_camera(53, 37, 31);
  camera.fy = 34.5, camera.cx = 19.3, camera.cy = 22.1;
  return camera;
}

void check_against_brute_force(const Conventions& k, const Camera& camera, double tolerance) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const Scene scene = random_scene(seed, 300);
    const BruteFrame expected = render_brute_force(scene, camera, k);
    const ReferenceFrame frame = render_reference(scene, camera, k);
    CHECK(expected.pixels_stopped > 0);
    CHECK(expected.visible > 30);
    CHECK(frame.visible == expected.visible);
    CHECK(frame.contributing_pairs == expected.contributing_pairs);
    CHECK(frame.pixels_stopped == expected.pixels_stopped);
    CHECK(max_abs_difference(frame.colour, expected.colour) < tolerance);
    CHECK(max_abs_difference(frame.alpha, expected.alpha) < tolerance);
    CHECK(max_abs_difference(frame.depth, expected.depth) < tolerance);
  }
}

TEST_CASE("reference: the gsplat preset agrees with every pixel against every Gaussian in long double") {
  check_against_brute_force(Conventions::gsplat(), off_centre_camera(), 1e-13);
}

TEST_CASE("reference: the inria preset agrees with every pixel against every Gaussian in long double") {
  check_against_brute_force(Conventions::inria(), off_centre_camera(), 1e-13);
}

TEST_CASE("reference: antialiased mode agrees with every pixel against every Gaussian in long double") {
  Conventions k;
  k.antialiased = true;
  check_against_brute_force(k, off_centre_camera(), 1e-13);
}

TEST_CASE("reference: a turned camera agrees with every pixel against every Gaussian in long double") {
  const Camera camera = look_at(dvec3(-1, 0.5, -2), dvec3(0.2, 0, 2), dvec3(0.1, -1, 0.2), 0.9, 53, 37);
  check_against_brute_force(Conventions::gsplat(), camera, 1e-13);
}

TEST_CASE("reference: the frame does not depend on the number of threads") {
  const Scene scene = random_scene(4, 300);
  const Camera camera = off_centre_camera();
  const ReferenceFrame one = render_reference(scene, camera, Conventions::gsplat(), dvec3(0.5), 1);
  for (const int threads : {0, 2, 3, 8}) {
    const ReferenceFrame frame = render_reference(scene, camera, Conventions::gsplat(), dvec3(0.5), threads);
    CHECK(frame.colour == one.colour);
    CHECK(frame.alpha == one.alpha);
    CHECK(frame.depth == one.depth);
    CHECK(frame.visible == one.visible);
    CHECK(frame.contributing_pairs == one.contributing_pairs);
    CHECK(frame.pixels_stopped == one.pixels_stopped);
  }
}

}  // namespace
}  // namespace swiftgs::test
