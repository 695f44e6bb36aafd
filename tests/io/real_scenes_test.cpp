// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <string>

#include <doctest/doctest.h>

#include <swiftgs/io/cameras.hpp>
#include <swiftgs/io/scene_file.hpp>

#include "scenes/captures.hpp"

namespace swiftgs::test::real_scenes_test {

namespace {

void check_scene(const std::string& name, const std::string& cameras_path, std::size_t gaussians,
                 std::size_t views, int width, int height) {
  const std::filesystem::path folder = test::capture_or_skip(name);
  if (folder.empty()) return;
  CAPTURE(name);
  const SceneFile file = read_scene(folder / (name + ".spz"));
  CHECK(file.format == "SPZ version 2");
  CHECK(file.stored == gaussians);
  CHECK(file.left_out.total() == 0);
  CHECK(file.scene.size() == gaussians);
  CHECK(file.scene.sh_degree == 3);
  CHECK(!file.scene.model.antialiased);
  const auto cameras = load_cameras(folder / cameras_path);
  CHECK(cameras.size() == views);
  for (const Camera& camera : cameras) {
    CHECK(camera.width == width);
    CHECK(camera.height == height);
  }
}

}  // namespace

TEST_CASE("real scenes: garden is read with its cameras") {
  check_scene("garden", "cameras.json", 1'512'439, 93, 1297, 840);
}

TEST_CASE("real scenes: herz is read with its cameras") { check_scene("herz", "", 716'580, 25, 1536, 1024); }

TEST_CASE("real scenes: fox is read with its cameras") {
  check_scene("fox", "sparse/0", 175'799, 50, 1067, 1897);
}

}  // namespace swiftgs::test::real_scenes_test
