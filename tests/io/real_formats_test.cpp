// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <filesystem>
#include <set>
#include <string>

#include <swiftgs/edit/order.hpp>
#include <swiftgs/io/scene_file.hpp>

#include "files.hpp"
#include "support/skip.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

const std::filesystem::path folder =
#ifdef SWIFTGS_FORMATS_DIR
    SWIFTGS_FORMATS_DIR;
#else
    "";
#endif

const std::filesystem::path scenes =
#ifdef SWIFTGS_SCENES_DIR
    SWIFTGS_SCENES_DIR;
#else
    "";
#endif

bool skipped() {
  if (folder.empty()) test::skip("no folder of real files");
  return folder.empty();
}

}  // namespace

TEST_CASE("real files: a PLY of another program is read and written unchanged") {
  if (skipped()) return;
  const SceneFile file = read_scene(folder / "fox_5k.ply");
  CHECK(file.format == "INRIA PLY (binary_little_endian)");
  CHECK(file.stored == 5000);
  CHECK(file.dropped_nonfinite == 0);
  CHECK(file.scene.sh_degree == 3);
  const TemporaryFolder temporary;
  write_scene(temporary / "again.ply", file.scene);
  const Scene again = load_scene(temporary / "again.ply");
  CHECK(again.means == file.scene.means);
  CHECK(again.sh0 == file.scene.sh0);
  CHECK(again.sh_rest == file.scene.sh_rest);
  CHECK(content_of(temporary / "again.ply").size() == content_of(folder / "fox_5k.ply").size());
}

TEST_CASE("real files: an SPZ version 4 of another program is read") {
  if (skipped()) return;
  const SceneFile file = read_scene(folder / "biker.spz");
  CHECK(file.format == "SPZ version 4");
  CHECK(file.stored == 152'746);
  CHECK(file.dropped_nonfinite == 0);
  CHECK(file.scene.sh_degree == 0);
  for (const Quaternion& q : file.scene.rotations)
    REQUIRE(std::abs(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z - 1) < 1e-5);
  for (const vec3& mean : file.scene.means)
    REQUIRE(std::abs(mean.x) + std::abs(mean.y) + std::abs(mean.z) < 100);
}

TEST_CASE("real files: a SOG of another program is read") {
  if (skipped()) return;
  const SceneFile file = read_scene(folder / "massa.sog");
  CHECK(file.format == "SOG version 2");
  CHECK(file.stored == 58'649);
  CHECK(file.dropped_nonfinite == 0);
  CHECK(file.scene.sh_degree == 0);
  CHECK(file.notes.empty());
  // What PlayCanvas's own reader makes of one of them.
  const std::size_t i = 12'345;
  const auto near = [](float value, double expected) { return std::abs(value - expected) < 1e-6; };
  CHECK(file.scene.means[i] == vec3(0.166090608f, -1.39745462f, -0.274810314f));
  CHECK(near(file.scene.scales[i].x, 0.000969918328));
  CHECK(near(file.scene.scales[i].y, 0.0115040196));
  CHECK(near(file.scene.scales[i].z, 0.00292622228));
  CHECK(near(file.scene.rotations[i].w, 0.732478261));
  CHECK(near(file.scene.rotations[i].x, 0.457539678));
  CHECK(near(file.scene.rotations[i].y, 0.047140453));
  CHECK(near(file.scene.rotations[i].z, -0.50190717));
  CHECK(near(file.scene.opacities[i], 0.984313726));
  CHECK(near(file.scene.sh0[i].x, -0.354490757));
  CHECK(near(file.scene.sh0[i].y, -0.590817928));
  CHECK(near(file.scene.sh0[i].z, -0.938357949));
}

TEST_CASE("real files: a compressed PLY of another program is read") {
  if (skipped()) return;
  const SceneFile file = read_scene(folder / "guitar.compressed.ply");
  CHECK(file.format == "compressed PLY");
  CHECK(file.stored == 90'854);
  CHECK(file.dropped_nonfinite == 0);
  CHECK(file.scene.sh_degree == 0);
  for (const vec3& mean : file.scene.means)
    REQUIRE(std::abs(mean.x) + std::abs(mean.y) + std::abs(mean.z) < 100);
}

TEST_CASE("real files: a .splat of another program is read") {
  if (skipped()) return;
  const SceneFile file = read_scene(folder / "luma_seal.splat");
  CHECK(file.format == ".splat");
  CHECK(file.stored == 101'780);
  CHECK(file.dropped_nonfinite == 0);
  CHECK(file.notes.empty());
  for (const vec3& mean : file.scene.means)
    REQUIRE(std::abs(mean.x) + std::abs(mean.y) + std::abs(mean.z) < 100);
}

TEST_CASE("real files: a PLY and an SPZ of one scene have the same axes") {
  if (skipped()) return;
  if (scenes.empty()) return test::skip("no folder of real scenes");
  // The PLY holds some Gaussians of the SPZ, whose grid is 1/4096 wide.
  using Cell = std::array<long, 3>;
  const auto cell = [](const vec3& p) {
    return Cell{std::lround(p.x * 4096), std::lround(p.y * 4096), std::lround(p.z * 4096)};
  };
  std::set<Cell> cells;
  for (const vec3& mean : load_scene(scenes / "fox/fox.spz").means) cells.insert(cell(mean));
  std::size_t found = 0;
  for (const vec3& mean : load_scene(folder / "fox_5k.ply").means) found += cells.count(cell(mean));
  CHECK(found == 5000);
}

TEST_CASE("real files: a scene that was once an SPZ is written as SPZ without loss") {
  if (skipped()) return;
  const Scene scene = load_scene(folder / "fox_5k.ply");
  const TemporaryFolder temporary;
  for (const int version : {3, 4}) {
    const WrittenScene written = write_scene(temporary / "a.spz", scene, {.spz_version = version});
    CHECK(written.notes.empty());
    CHECK(written.bytes < 125'000);
    const Scene again = load_scene(temporary / "a.spz");
    CHECK(again.means == scene.means);
    CHECK(again.sh_rest == scene.sh_rest);
    for (std::size_t i = 0; i < scene.size(); ++i) {
      // The PLY cannot hold 0 and 1.
      REQUIRE(std::abs(again.opacities[i] - scene.opacities[i]) < 1.1e-4);
      for (int axis = 0; axis < 3; ++axis) {
        REQUIRE(std::abs(again.sh0[i][axis] - scene.sh0[i][axis]) < 1e-6);
        REQUIRE(std::abs(again.scales[i][axis] / scene.scales[i][axis] - 1) < 1e-5);
      }
    }
  }
}

TEST_CASE("real files: a scene loses no more in a SOG than bytes for its numbers explain") {
  if (skipped()) return;
  const Scene scene = order_spatially(load_scene(folder / "fox_5k.ply"));
  const TemporaryFolder temporary;
  write_scene(temporary / "a.sog", scene);
  const SceneFile file = read_scene(temporary / "a.sog");
  CHECK(file.notes.empty());
  const Scene& read = file.scene;
  REQUIRE(read.size() == 5000);
  CHECK(read.sh0 == scene.sh0);  // the PLY holds fewer than 256 different numbers
  double squares = 0;
  for (std::size_t i = 0; i < scene.sh_rest.size(); ++i)
    squares += std::pow(double(read.sh_rest[i]) - scene.sh_rest[i], 2);
  CHECK(std::sqrt(squares / double(scene.sh_rest.size())) < 1e-3);
  for (std::size_t i = 0; i < read.size(); ++i) {
    CHECK(std::abs(read.opacities[i] - scene.opacities[i]) <= 0.5001f / 255);
    for (int axis = 0; axis < 3; ++axis) {
      CHECK(std::abs(read.means[i][axis] - scene.means[i][axis]) < 3e-4);
      CHECK(read.scales[i][axis] == doctest::Approx(scene.scales[i][axis]).epsilon(1e-5));
    }
  }
}
