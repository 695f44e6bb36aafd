// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/default_view.hpp>
#include <swiftgs/edit/transform.hpp>

using namespace swiftgs;

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

Scene scene_of(const std::vector<vec3>& means, float size = 0.01f) {
  Scene scene;
  scene.means = means;
  scene.scales.assign(means.size(), vec3(size));
  scene.rotations.resize(means.size());
  scene.opacities.assign(means.size(), 0.9f);
  scene.sh0.resize(means.size());
  return scene;
}

/// A grid of `side`^3 points in a box around `centre`.
Scene box_of(vec3 centre, vec3 half, int side = 11) {
  std::vector<vec3> means;
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j)
      for (int k = 0; k < side; ++k)
        means.push_back(centre + half * (2.0f * vec3(float(i), float(j), float(k)) / float(side - 1) - 1.0f));
  return scene_of(means);
}

/// Where a camera shows a point @units{pixels}, and its depth.
dvec3 seen(const Camera& camera, const dvec3& point) {
  const dvec3 p = camera.rotation * point + camera.translation;
  return {camera.fx * p.x / p.z + camera.cx, camera.fy * p.y / p.z + camera.cy, p.z};
}

/// A view from the front, and one whose axes all differ.
const OrbitView front{look_at(dvec3(0, 0, -4), dvec3(0), dvec3(0, -1, 0), 0.8, 64, 36)};
const OrbitView tilted{look_at(dvec3(0, 0, -4), dvec3(1, 0.5, 0), dvec3(0.2, -1, 0), 0.8, 640, 360),
                       dvec3(0.3, -0.2, 0.5), dvec3(0, -2, 0)};

double distance(const Camera& camera, const dvec3& point) { return glm::length(camera.centre() - point); }

/// Angle between `up` and the way from `target` to the camera.
double angle_to_up(const Camera& camera, const OrbitView& view) {
  return std::acos(glm::dot(glm::normalize(view.up), glm::normalize(camera.centre() - view.target)));
}

}  // namespace

TEST_CASE("bounds: strays do not move them") {
  Scene scene = box_of(vec3(5, -2, 1), vec3(1, 2, 3));
  const SceneBounds clean = robust_bounds(scene);
  CHECK(glm::length(clean.centre - dvec3(5, -2, 1)) < 1e-6);
  CHECK(glm::length(clean.low - dvec3(4, -4, -2)) < 0.1);
  CHECK(glm::length(clean.high - dvec3(6, 0, 4)) < 0.1);
  CHECK(clean.radius == doctest::Approx(2.2).epsilon(0.15));
  for (std::size_t i = 0; i < 13; ++i)  // one in a hundred
    scene.means[i * 97] = vec3(1e30f, i % 2 ? -1e20f : 1e6f, 1e4f);
  const SceneBounds stray = robust_bounds(scene);
  CHECK(glm::length(stray.low - clean.low) < 0.7);
  CHECK(glm::length(stray.high - clean.high) < 0.7);
  CHECK(glm::length(stray.centre - clean.centre) < 0.5);
  CHECK(stray.radius == doctest::Approx(clean.radius).epsilon(0.02));
  CHECK(stray.high.x < 6.1);
}

TEST_CASE("bounds: faint Gaussians have no part in them unless all are faint") {
  Scene scene = box_of(vec3(0), vec3(1));
  const Scene other = box_of(vec3(50), vec3(1));
  scene.means.insert(scene.means.end(), other.means.begin(), other.means.end());
  scene = scene_of(scene.means);
  for (std::size_t i = other.size(); i < scene.size(); ++i) scene.opacities[i] = 0.1f;
  CHECK(robust_bounds(scene).high.x < 1.1);
  scene.opacities.assign(scene.size(), 0.1f);
  CHECK(robust_bounds(scene).high.x > 50);
}

TEST_CASE("bounds: no Gaussians and one and what is not a number have bounds") {
  const auto check = [](const Scene& scene) {
    const SceneBounds bounds = robust_bounds(scene);
    for (int axis = 0; axis < 3; ++axis) {
      CHECK(std::isfinite(bounds.low[axis]));
      CHECK(std::isfinite(bounds.high[axis]));
      CHECK(bounds.low[axis] <= bounds.centre[axis]);
      CHECK(bounds.centre[axis] <= bounds.high[axis]);
    }
    CHECK(bounds.radius > 0);
    CHECK(std::isfinite(bounds.radius));
    const OrbitView view = default_view(scene, 64, 48);
    validate(view.camera);
    CHECK(view.camera.width == 64);
    CHECK(view.target == bounds.centre);
    CHECK(glm::length(view.up) == doctest::Approx(1));
    CHECK(distance(view.camera, view.target) > 0.9 * bounds.radius);
    return bounds;
  };
  CHECK(check(Scene()).radius == 1);
  const SceneBounds one = check(scene_of({vec3(1, 2, 3)}, 0.5f));
  CHECK(one.centre == dvec3(1, 2, 3));
  CHECK(one.radius == 1.5);
  CHECK(one.low == dvec3(0.5, 1.5, 2.5));
  CHECK(check(scene_of({vec3(1e6f, 0, 0)}, 0)).radius == doctest::Approx(1));
  check(scene_of({vec3(3e38f, -3e38f, 3e38f), vec3(-3e38f)}, 1e30f));
  check(scene_of({vec3(1e-30f), vec3(2e-30f)}, 0));
  CHECK(check(scene_of({vec3(NAN), vec3(0, infinity, 0)})).radius == 1);
  Scene mixed = scene_of({vec3(7), vec3(8), vec3(9), vec3(10)}, 0);
  mixed.means[0].z = NAN, mixed.scales[1].y = infinity, mixed.sh0[2].x = NAN;
  CHECK(check(mixed).centre == dvec3(10));
  mixed.opacities[3] = NAN;
  CHECK(check(mixed).centre == dvec3(10));
}

TEST_CASE("default view: most of a scene is seen in an image of any shape") {
  for (const auto& [width, height] : {std::pair{640, 360}, {360, 640}, {500, 500}}) {
    const Scene scene = box_of(vec3(5, -2, 1), vec3(1, 0.3f, 2));
    const OrbitView view = default_view(scene, width, height);
    CHECK(view.camera.width == width);
    CHECK(view.camera.height == height);
    CHECK(view.target == robust_bounds(scene).centre);
    std::size_t inside = 0;
    for (const vec3& mean : scene.means) {
      const dvec3 at = seen(view.camera, dvec3(mean));
      inside += at.z > 0 && at.x > 0 && at.x < width && at.y > 0 && at.y < height;
    }
    CHECK(inside > scene.size() / 3);
    const double shorter_fov = 2 * std::atan(0.5 * std::min(width, height) / view.camera.fx);
    CHECK(shorter_fov == doctest::Approx(0.8));
    const dvec3 middle = seen(view.camera, view.target);
    CHECK(middle.x == doctest::Approx(width / 2.0));
    CHECK(middle.y == doctest::Approx(height / 2.0));
    // Up is up, and the camera looks down a little.
    CHECK(seen(view.camera, view.target + 0.1 * view.up).y < middle.y);
    CHECK(angle_to_up(view.camera, view) == doctest::Approx(std::atan2(0.92, 0.39)));
  }
}

TEST_CASE("default view: an image without pixels or with too many is refused") {
  const Scene scene = box_of(vec3(0), vec3(1), 3);
  for (const auto& [width, height] : {std::pair{0, 360}, {360, 0}, {-1, 1}, {65537, 1}, {1, 65537}})
    CHECK_THROWS_AS(default_view(scene, width, height), std::invalid_argument);
  CHECK_THROWS_WITH_AS(default_view(scene, 0, 360),
                       "default_view: the image is 0 x 360, expected 1 to 65536 pixels a side",
                       std::invalid_argument);
  validate(default_view(scene, 1, 65536).camera);
}

TEST_CASE("default view: up is where it is told and -y unless much speaks for another axis") {
  const Scene scene = make_builtin_scene(5000);
  CHECK(default_view(scene).up.y < -0.9);
  // Of the same scene, told where up is, the start is the same view in any world.
  const double far =
      distance(default_view(scene, 64, 48, dvec3(0, -5, 0)).camera, robust_bounds(scene).centre);
  for (const dmat3& rotation : {dmat3(1, 0, 0, 0, -1, 0, 0, 0, -1), dmat3(1, 0, 0, 0, 0, -1, 0, 1, 0)}) {
    Scene turned = scene;
    transform(turned, {.rotation = rotation});
    const dvec3 told = rotation * dvec3(0, -1, 0);
    const OrbitView view = default_view(turned, 64, 48, 5.0 * told);
    CHECK(glm::length(view.up - told) < 1e-12);
    CHECK(distance(view.camera, view.target) == doctest::Approx(far).epsilon(0.01));
  }
}

TEST_CASE("orbit: the target stays in its pixel and the camera where it was told") {
  OrbitView view = tilted;
  view.camera.cx += 31;
  const dvec3 before = seen(view.camera, view.target);
  const double far = distance(view.camera, view.target), high = angle_to_up(view.camera, view);
  for (const double turn : {0.0, 0.7, -2.0, 9.0})
    for (const double rise : {0.0, 0.3, -0.4})
      for (const double times : {1.0, 0.25}) {
        const Camera camera = orbit(view, turn, rise, times);
        validate(camera);
        const dvec3 after = seen(camera, view.target);
        CHECK(after.x == doctest::Approx(before.x));
        CHECK(after.y == doctest::Approx(before.y));
        CHECK(distance(camera, view.target) == doctest::Approx(times * far));
        CHECK(angle_to_up(camera, view) == doctest::Approx(high - rise));
        CHECK(camera.fx == view.camera.fx);
        CHECK(camera.cx == view.camera.cx);
        // The image turns with it: the axis stands in it as it did.
        if (rise != 0) continue;
        const dvec3 axis = seen(camera, view.target + 0.1 * times * view.up);  // of the same angle
        const dvec3 stood = seen(view.camera, view.target + 0.1 * view.up);
        CHECK(axis.x == doctest::Approx(stood.x));
        CHECK(axis.y == doctest::Approx(stood.y));
      }
  // From the front, a positive turn brings the camera to the right of what it saw.
  CHECK(glm::length(orbit(front, std::numbers::pi / 2).centre() - dvec3(4, 0, 0)) < 1e-12);
  CHECK(orbit(front, 0, 0.5).centre().y < 0);
  CHECK(glm::length(orbit(view, 0).translation - view.camera.translation) < 1e-12);
}

TEST_CASE("orbit: an orthographic camera shows the target in its pixel and as large as a pinhole would") {
  OrbitView view = tilted;
  view.camera.lens.model = LensModel::orthographic;
  view.camera.fx = 70, view.camera.fy = 80;
  const auto at = [](const Camera& camera, const dvec3& point) {
    const dvec3 p = camera.rotation * point + camera.translation;
    return dvec3(camera.fx * p.x + camera.cx, camera.fy * p.y + camera.cy, 0);
  };
  const dvec3 before = at(view.camera, view.target);
  const double far = distance(view.camera, view.target);
  for (const double times : {0.25, 1.0, 3.0}) {
    const Camera camera = orbit(view, 0.7, 0.3, times);
    CHECK(glm::length(at(camera, view.target) - before) < 1e-9);
    CHECK(distance(camera, view.target) == doctest::Approx(times * far));
    const dvec3 right(camera.rotation[0][0], camera.rotation[1][0], camera.rotation[2][0]);
    CHECK(at(camera, view.target + right).x - before.x == doctest::Approx(70 / times));
    CHECK(camera.fy == doctest::Approx(80 / times));
  }
}

TEST_CASE("orbit: a camera never goes over the top") {
  OrbitView view = front;
  const double degree = std::numbers::pi / 180;
  for (const double rise : {1.6, 100.0}) {
    CHECK(angle_to_up(orbit(view, 0.3, rise), view) == doctest::Approx(degree));
    CHECK(angle_to_up(orbit(view, 0.3, -rise), view) == doctest::Approx(std::numbers::pi - degree));
  }
  for (int i = 0; i < 1000; ++i) view.camera = orbit(view, 0.1, i % 3 ? 0.2 : -0.3);
  validate(view.camera);
  CHECK(distance(view.camera, view.target) == doctest::Approx(4));
  // From the axis itself it only turns.
  const OrbitView top{look_at(dvec3(0, -4, 0), dvec3(0), dvec3(0, 0, 1), 0.8, 64, 36)};
  CHECK(glm::length(orbit(top, 1, -0.5).centre() - dvec3(0, -4, 0)) < 1e-12);
}

TEST_CASE("orbit: what is no movement is refused") {
  OrbitView view = front;
  CHECK_THROWS_AS(orbit(view, NAN), std::invalid_argument);
  CHECK_THROWS_AS(orbit(view, 0, double(infinity)), std::invalid_argument);
  CHECK_THROWS_AS(orbit(view, 0, 0, 0), std::invalid_argument);
  CHECK_THROWS_AS(orbit(view, 0, 0, -1), std::invalid_argument);
  view.up = dvec3(0);
  CHECK_THROWS_WITH_AS(orbit(view, 0), "orbit: expected an up of a finite length above 0",
                       std::invalid_argument);
}
