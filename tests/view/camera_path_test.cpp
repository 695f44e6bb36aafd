// SPDX-License-Identifier: Apache-2.0
#include "view/camera_path.hpp"

#include <cmath>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include <swiftgs/edit/transform.hpp>
#include <swiftgs/io/cameras.hpp>

#include "support/files.hpp"

using namespace swiftgs;
using namespace swiftgs::cli;
using nlohmann::json;
using swiftgs::test::TemporaryFolder;

namespace {

/// Three keys around a target, more than half a turn between the first and the last.
CameraPath three_keys() {
  CameraPath path;
  const auto add = [&](dvec3 eye, double fov) {
    path.keys.push_back(look_at(eye, dvec3(0, 0.5, 0), dvec3(0, -1, 0), fov, 640, 360));
  };
  add({0, 0, -3}, 0.7), add({3, -1, 1}, 0.9), add({-3, 0, 2}, 0.7);
  return path;
}

double angle(const Camera& camera) { return 2 * std::atan(0.5 * camera.height / camera.fy); }

void check_same_view(const Camera& a, const Camera& b, double within = 1e-9) {
  for (int i = 0; i < 3; ++i) {
    CHECK(std::abs(a.centre()[i] - b.centre()[i]) < within);
    for (int j = 0; j < 3; ++j) CHECK(std::abs(a.rotation[i][j] - b.rotation[i][j]) < within);
  }
  CHECK(std::abs(angle(a) - angle(b)) < within);
}

double largest_step(const CameraPath& path, double from, double to) {
  double largest = 0;
  const Camera a = camera_at(path, from, 64, 36), b = camera_at(path, to, 64, 36);
  for (int i = 0; i < 3; ++i) {
    largest = std::fmax(largest, std::abs(a.centre()[i] - b.centre()[i]));
    for (int j = 0; j < 3; ++j) largest = std::fmax(largest, std::abs(a.rotation[i][j] - b.rotation[i][j]));
  }
  return largest;
}

}  // namespace

TEST_CASE("view path: a flight goes through its keys and stands before and after") {
  const CameraPath path = three_keys();
  CHECK(path.seconds() == 4);
  for (int key = 0; key < 3; ++key) {
    const Camera camera = camera_at(path, 2 * key, 320, 180);
    check_same_view(camera, path.keys[std::size_t(key)]);
    CHECK(camera.width == 320);
    CHECK(camera.cy == 90);
  }
  check_same_view(camera_at(path, -1, 320, 180), path.keys[0]);
  check_same_view(camera_at(path, 9, 320, 180), path.keys[2]);
  const CameraPath alone{.keys = {path.keys[1]}};
  CHECK(alone.seconds() == 0);
  check_same_view(camera_at(alone, 1, 320, 180), path.keys[1]);
}

TEST_CASE("view path: a flight is smooth and each of its cameras is valid") {
  const CameraPath path = three_keys();
  const double step = 1e-4;
  for (double t = 0; t <= 4; t += 0.05) CHECK_NOTHROW(validate(camera_at(path, t, 64, 36)));
  // Before and after the middle key it is as fast, and nowhere it jumps.
  const double before = largest_step(path, 2 - step, 2), after = largest_step(path, 2, 2 + step);
  CHECK(before == doctest::Approx(after).epsilon(0.01));
  CHECK(before > 0.2 * step);
  for (double t = 0; t < 4; t += 0.02) CHECK(largest_step(path, t, t + step) < 10 * step);
  // A straight line at one speed stays so.
  CameraPath line;
  for (const double z : {0.0, 1.0, 2.0, 3.0})
    line.keys.push_back(look_at({0, 0, z}, {0, 0, 9}, {0, -1, 0}, 0.8, 64, 36));
  CHECK(camera_at(line, 3, 64, 36).centre().z == doctest::Approx(1.5));
  CHECK(camera_at(line, 2.5, 64, 36).centre().z == doctest::Approx(1.25));
}

TEST_CASE("view path: what is written is read again and is what other programs read") {
  const TemporaryFolder folder;
  const auto file = folder / "camera_path.json";
  const dvec3 origin(1000, 0, -5);
  CameraPath path = three_keys();
  path.seconds_a_key = 0.5, path.frames_a_second = 10;
  write_camera_path(file, path, 320, 180, origin);

  const CameraPath again = read_camera_path(file, origin);
  REQUIRE(again.keys.size() == 3);
  CHECK(again.seconds_a_key == 0.5);
  CHECK(again.frames_a_second == 10);
  for (std::size_t i = 0; i < 3; ++i) check_same_view(again.keys[i], path.keys[i]);

  const CameraFile frames = read_cameras(file);
  CHECK(frames.notes.empty());
  CHECK(frames.frames_a_second == 10);
  REQUIRE(frames.cameras.size() == 11);
  for (std::size_t i = 0; i < 11; ++i) {
    CHECK(frames.cameras[i].width == 320);
    const Camera here = transformed(frames.cameras[i], {.translation = -origin});
    check_same_view(here, camera_at(path, 0.1 * double(i), 320, 180));
  }
}

TEST_CASE("view path: a path whose keys have other times or none is read by its frames") {
  const TemporaryFolder folder;
  const auto file = folder / "camera_path.json";
  CameraPath path = three_keys();
  path.frames_a_second = 5;
  write_camera_path(file, path, 320, 180, dvec3(0));
  const auto check_frames = [&](auto change) {
    json root = json::parse(test::content_of(file));
    change(root);
    const CameraPath frames = read_camera_path(folder.write("other.json", root.dump()), dvec3(0));
    REQUIRE(frames.keys.size() == 21);
    CHECK(frames.seconds_a_key == 0.2);
    CHECK(frames.seconds() == doctest::Approx(4));
    check_same_view(camera_at(frames, 2.2, 64, 36), camera_at(path, 2.2, 64, 36));
  };
  check_frames([](json& root) { root.erase("keyframes"); });
  check_frames([](json& root) { root["seconds"] = 5.0; });
  check_frames([](json& root) { root["keyframes"][1]["matrix"] = "[1, 0, 0]"; });
  check_frames([](json& root) { root["keyframes"][1]["fov"] = 180; });
  check_frames([](json& root) { root["keyframes"] = json::array(); });
  check_frames([](json& root) { root["default_transition_sec"] = -2.0; });

  CHECK_THROWS_AS(read_camera_path(folder / "none.json", dvec3(0)), std::exception);
  const auto empty =
      folder.write("empty.json", R"({"camera_path": [], "render_width": 4, "render_height": 4})");
  CHECK_THROWS_WITH_AS(read_camera_path(empty, dvec3(0)),
                       (empty.string() + ": expected at least one camera, found none").c_str(),
                       std::invalid_argument);
}
