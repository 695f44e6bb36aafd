// SPDX-License-Identifier: Apache-2.0
#include "view/navigation.hpp"

#include <cmath>
#include <numbers>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

using namespace swiftgs;
using namespace swiftgs::cli;

namespace {

constexpr Navigation all[] = {Navigation::orbit, Navigation::fly, Navigation::walk};

/// From 5 in front of the target, a little above it; y points down.
OrbitView start() {
  const dvec3 target(1, 2, 3), up(0, -1, 0);
  return {look_at(target + dvec3(0, -1, -5), target, up, 0.8, 640, 360), target, up};
}

dvec3 forward_of(const OrbitView& view) {
  const dmat3& r = view.camera.rotation;
  return {r[0][2], r[1][2], r[2][2]};
}

/// Where the view has a point of the world. @units{pixels}
dvec3 seen(const OrbitView& view, const dvec3& point) {
  const dvec3 p = view.camera.rotation * point + view.camera.translation;
  return {view.camera.fx * p.x / p.z + view.camera.cx, view.camera.fy * p.y / p.z + view.camera.cy, p.z};
}

void check_equal(const dvec3& a, const dvec3& b) {
  for (int i = 0; i < 3; ++i) CHECK(a[i] == doctest::Approx(b[i]).epsilon(1e-9));
}

}  // namespace

TEST_CASE("view navigation: an orbit goes around its target and keeps it in the middle") {
  const OrbitView before = start(), after = moved(before, Navigation::orbit, {.turn = {40, 30}});
  check_equal(after.target, before.target);
  check_equal(seen(after, after.target), seen(before, before.target));
  // What was dragged to the right and down went there: a point before the target follows the mouse.
  const dvec3 near_point = before.target - 1.0 * forward_of(before);
  CHECK(seen(after, near_point).x > seen(before, near_point).x + 5);
  CHECK(seen(after, near_point).y > seen(before, near_point).y + 5);
  CHECK(seen(moved(before, Navigation::orbit, {.wheel = 1}), before.target).z ==
        doctest::Approx(0.9 * seen(before, before.target).z));
}

TEST_CASE("view navigation: flying looks to where the mouse goes and stays in its place") {
  for (const Navigation navigation : {Navigation::fly, Navigation::walk}) {
    const OrbitView before = start(), after = moved(before, navigation, {.turn = {40, 30}});
    check_equal(after.camera.centre(), before.camera.centre());
    CHECK(seen(after, before.target).x < seen(before, before.target).x - 5);
    CHECK(seen(after, before.target).y < seen(before, before.target).y - 5);
    check_equal(seen(after, after.target), seen(before, before.target));  // an orbit can go on from here
    CHECK(after.camera.rotation[1][0] == doctest::Approx(0.0));           // no roll
  }
}

TEST_CASE("view navigation: nothing turns the camera over") {
  for (const Navigation navigation : all)
    for (const float down : {30.0f, -30.0f}) {
      OrbitView view = start();
      for (int i = 0; i < 60; ++i) view = moved(view, navigation, {.turn = {7, down}});
      CHECK(view.camera.rotation[1][1] > 0);  // the camera's down is down
      CHECK(view.camera.rotation[1][0] == doctest::Approx(0.0));
      CHECK(std::abs(forward_of(view).y) > 0.99);
      CHECK_NOTHROW(validate(view.camera));
    }
}

TEST_CASE("view navigation: keys go along the camera and walking stays level") {
  for (const Navigation navigation : all) {
    const OrbitView before = start(), after = moved(before, navigation, {.move = {0.5, 0, 2}});
    const dvec3 way = after.camera.centre() - before.camera.centre();
    CHECK(glm::length(way) == doctest::Approx(std::hypot(0.5, 2)));
    CHECK(way.x == doctest::Approx(0.5));
    check_equal(after.target - before.target, way);
    const bool is_level = std::abs(way.y) < 1e-12;
    CHECK(is_level == (navigation == Navigation::walk));
    const OrbitView higher = moved(before, navigation, {.move = {0, 3, 0}});
    check_equal(higher.camera.centre() - before.camera.centre(), {0, -3, 0});
  }
  // The wheel goes ahead where nothing is orbited.
  const OrbitView ahead = moved(start(), Navigation::fly, {.wheel = 2});
  CHECK(glm::dot(ahead.camera.centre() - start().camera.centre(), forward_of(start())) > 0.5);
}

TEST_CASE("view navigation: the target's distance goes with the mouse that pans") {
  for (const Navigation navigation : all) {
    const OrbitView before = start(), after = moved(before, navigation, {.pan = {25, -10}});
    const dvec3 was = seen(before, before.target), is = seen(after, before.target);
    check_equal(is, was + dvec3(25, -10, 0));
    CHECK(after.camera.rotation == before.camera.rotation);
  }
}

TEST_CASE("view navigation: no input changes nothing") {
  CHECK_FALSE(Input().moves());
  CHECK(Input{.wheel = 1}.moves());
  for (const Navigation navigation : all) {
    const OrbitView after = moved(start(), navigation, {});
    CHECK(after.camera.translation == start().camera.translation);
    CHECK(after.camera.rotation == start().camera.rotation);
    CHECK(after.target == start().target);
  }
}

TEST_CASE("view navigation: a camera fits into a window with all of its image") {
  Camera camera = start().camera;
  camera.cx += 10;
  const Camera wide = fitted(camera, 1280, 360), tall = fitted(camera, 320, 360);
  CHECK(wide.fy == camera.fy);
  CHECK(wide.cx == 640 + 10);
  CHECK(wide.cy == 180);
  CHECK(tall.fx == camera.fx / 2);
  CHECK(tall.cx == 160 + 5);
  CHECK(tall.width == 320);
  CHECK(tall.height == 360);

  Camera panorama = camera;
  panorama.lens.model = LensModel::equirectangular;
  panorama.fx = panorama.fy = panorama.width / (2 * std::numbers::pi), panorama.cx = 320;
  CHECK_NOTHROW(validate(fitted(panorama, 1280, 300)));
  CHECK_NOTHROW(validate(fitted(panorama, 300, 720)));
}

TEST_CASE("view navigation: a camera's target is ahead of it") {
  const OrbitView from = start();
  const OrbitView view = view_through(from.camera, from.up, from.target + dvec3(1, 0, 0), 0.1);
  check_equal(view.target, from.target);
  const OrbitView behind = view_through(from.camera, from.up, from.camera.centre() - forward_of(from), 0.1);
  check_equal(behind.target, from.camera.centre() + 0.1 * forward_of(from));
}
