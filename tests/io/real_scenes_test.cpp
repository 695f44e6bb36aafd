// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <filesystem>
#include <string>

#include <doctest/doctest.h>

#include <swiftgs/io/cameras.hpp>
#include <swiftgs/io/image.hpp>
#include <swiftgs/io/scene_file.hpp>

#include "support/skip.hpp"

using namespace swiftgs;

namespace {

const std::filesystem::path folder =
#ifdef SWIFTGS_SCENES_DIR
    SWIFTGS_SCENES_DIR;
#else
    "";
#endif

bool skipped() {
  if (folder.empty()) test::skip("no folder of real scenes");
  return folder.empty();
}

void check_scene(const std::string& name, const std::string& cameras_path, std::size_t gaussians,
                 std::size_t views, int width, int height) {
  CAPTURE(name);
  const SceneFile file = read_scene(folder / name / (name + ".spz"));
  CHECK(file.format == "SPZ version 2");
  CHECK(file.stored == gaussians);
  CHECK(file.dropped_nonfinite == 0);
  CHECK(file.scene.size() == gaussians);
  CHECK(file.scene.sh_degree == 3);
  CHECK(!file.scene.antialiased);
  const auto cameras = read_cameras(folder / name / cameras_path);
  CHECK(cameras.size() == views);
  for (const Camera& camera : cameras) {
    CHECK(camera.width == width);
    CHECK(camera.height == height);
  }
}

}  // namespace

TEST_CASE("real scenes: garden is read with its cameras") {
  if (!skipped()) check_scene("garden", "cameras.json", 1'512'439, 93, 1297, 840);
}

TEST_CASE("real scenes: herz is read with its cameras") {
  if (!skipped()) check_scene("herz", "", 716'580, 25, 1536, 1024);
}

TEST_CASE("real scenes: fox is read with its cameras") {
  if (!skipped()) check_scene("fox", "sparse/0", 175'799, 50, 1067, 1897);
}

TEST_CASE("real scenes: photographs have the size of their cameras") {
  if (skipped()) return;
  for (const std::string name : {"garden", "herz", "fox"}) {
    const auto cameras = read_cameras(folder / name / (name == "garden" ? "cameras.json" : "sparse/0"));
    std::size_t matched = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder / name / "photos"))
      for (const Camera& camera : cameras) {
        if (std::filesystem::path(camera.name).stem() != entry.path().stem()) continue;
        const Image image = read_image(entry.path());
        CHECK(image.width == camera.width);
        CHECK(image.height == camera.height);
        CHECK(image.channels == 3);
        double mean = 0;
        for (const float value : image.pixels) mean += value;
        mean /= double(image.pixels.size());
        CHECK(mean > 0.1);
        CHECK(mean < 0.9);
        ++matched;
      }
    CHECK(matched == (name == "garden" ? 12 : name == "herz" ? 4 : 7));
  }
}
