// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/io/scene_file.hpp>

#include "name_ending.hpp"
#include "scenes.hpp"
#include "support/files.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

const std::vector<std::string> names = {"a.ply", "a.compressed.ply", "a.spz", "a.sog", "a.splat"};

/// Numbers within what every format holds, and of degree 0.
Scene modest_scene(std::size_t count) {
  Scene scene = some_scene(count, 0);
  for (vec3& colour : scene.sh0) colour *= 0.5f;
  return scene;
}

}  // namespace

TEST_CASE("writers: a scene of legal numbers is written whole and without a note") {
  const TemporaryFolder folder;
  for (const std::string& name : names) {
    CAPTURE(name);
    const WrittenScene written = write_scene(folder / name, modest_scene(300));
    CHECK(written.notes.empty());
    CHECK(written.gaussians == 300);
    CHECK(load_scene(folder / name).size() == 300);
  }
}

TEST_CASE("writers: scales of 0 are written as finite numbers") {
  const TemporaryFolder folder;
  for (const bool all : {false, true})
    for (const std::string& name : names) {
      CAPTURE(name);
      CAPTURE(all);
      Scene scene = modest_scene(300);
      for (std::size_t i = 0; i < scene.size(); ++i)
        if (all)
          scene.scales[i] = vec3(0.0f);
        else if (i % 2 == 0)
          scene.scales[i].z = 0;
      write_scene(folder / name, scene);
      const std::string content = content_of(folder / name);
      const std::size_t header = content.find("end_header\n");
      if (header != std::string::npos)  // floats: all of a PLY, and the ranges of a compressed one
        for (std::size_t at = header + 11, k = 0; at + 4 <= content.size() && (name == "a.ply" || k < 36);
             at += 4, ++k) {
          float number = 0;
          std::memcpy(&number, content.data() + at, 4);
          CHECK(std::isfinite(number));
        }
      for (const char* word : {"inf", "nan", "null"})
        if (name == "a.sog") CHECK(!contains(content.substr(0, content.find("means_l.webp")), word));
      const SceneFile file = read_scene(folder / name);
      CHECK(file.dropped_nonfinite == 0);
      REQUIRE(file.scene.size() == 300);
      // The least scale of the format: SPZ and compressed PLY have no 0, and their writers say so.
      const float least = name == "a.spz"              ? std::exp(-10.0f)
                          : name == "a.compressed.ply" ? std::exp(-20.0f)
                                                       : 0;
      std::size_t flat = 0;
      for (const vec3& scale : file.scene.scales) flat += scale.z >= 0 && scale.z <= least * 1.0001f;
      CHECK(flat == (all ? 300 : 150));
    }
}

TEST_CASE("writers: every format leaves out or changes the same numbers and counts them") {
  constexpr float infinity = std::numeric_limits<float>::infinity(),
                  nan = std::numeric_limits<float>::quiet_NaN();
  Scene scene = modest_scene(300);
  scene.means[10].y = infinity;
  scene.scales[11].z = nan;
  scene.rotations[12].w = -infinity;
  scene.opacities[13] = nan;
  scene.sh0[14].x = infinity;
  scene.opacities[20] = 1.5f, scene.opacities[21] = -0.25f, scene.opacities[22] = 1, scene.opacities[23] = 0;
  scene.scales[30] = vec3(-1, 2, -0.5f);
  scene.rotations[40] = {0, 0, 0, 0};
  const std::vector<std::string> notes = {"Gaussians with a NaN or an infinity are left out: 5.",
                                          "Opacities are clamped to 0 to 1: 2.",
                                          "Scales below 0 are written without their sign, of Gaussians: 1."};
  const TemporaryFolder folder;
  for (const std::string& name : names) {
    CAPTURE(name);
    const WrittenScene written = write_scene(folder / name, scene);
    CHECK(written.notes == notes);
    CHECK(written.gaussians == 295);
    const SceneFile file = read_scene(folder / name);
    CHECK(file.notes.empty());
    CHECK(file.dropped_nonfinite == 0);
    REQUIRE(file.scene.size() == 295);
    const auto index_of = [&](std::size_t i) {  // in the file, as orders differ
      const auto distance = [&](const vec3& mean) { return glm::distance(mean, scene.means[i]); };
      const auto nearest = std::min_element(file.scene.means.begin(), file.scene.means.end(),
                                            [&](auto a, auto b) { return distance(a) < distance(b); });
      return std::size_t(nearest - file.scene.means.begin());
    };
    CHECK(std::abs(file.scene.opacities[index_of(20)] - 1) <= 2e-6);
    CHECK(std::abs(file.scene.opacities[index_of(21)]) <= 2e-6);
    CHECK(file.scene.scales[index_of(30)].x == doctest::Approx(1).epsilon(0.05));
    CHECK(file.scene.scales[index_of(30)].z == doctest::Approx(0.5).epsilon(0.05));
    CHECK(std::abs(file.scene.rotations[index_of(40)].w) == doctest::Approx(1).epsilon(1e-4));
  }
}

TEST_CASE("writers: a NaN among the harmonics leaves its Gaussian out in every format") {
  Scene scene = some_scene(20, 2);
  scene.sh_rest[24 * 3 + 7] = std::nanf("");
  const TemporaryFolder folder;
  for (const std::string& name : names) {
    CAPTURE(name);
    const WrittenScene written = write_scene(folder / name, scene);
    CHECK(written.gaussians == 19);
    REQUIRE(!written.notes.empty());
    CHECK(written.notes[0] == "Gaussians with a NaN or an infinity are left out: 1.");
  }
}

TEST_CASE("writers: what is said to be in a file is what a reader finds") {
  const TemporaryFolder folder;
  for (const std::string& name : names)
    for (const bool antialiased : {false, true})
      for (int degree = 0; degree <= 3; ++degree) {
        CAPTURE(name);
        CAPTURE(degree);
        Scene scene = some_scene(100, degree);
        scene.antialiased = antialiased;
        const WrittenScene written = write_scene(folder / name, scene);
        const SceneFile file = read_scene(folder / name);
        CHECK(written.format == file.format);
        CHECK(written.bytes == std::filesystem::file_size(folder / name));
        CHECK(written.gaussians == file.scene.size());
        CHECK(written.sh_degree == file.scene.sh_degree);
        CHECK(written.antialiased == file.scene.antialiased);
      }
}

TEST_CASE("writers: endings are known in upper and lower case") {
  const TemporaryFolder folder;
  const Scene scene = some_scene(10, 0);
  CHECK(write_scene(folder / "A.PLY", scene).format == "INRIA PLY (binary_little_endian)");
  CHECK(write_scene(folder / "A.Compressed.Ply", scene).format == "compressed PLY");
  CHECK(write_scene(folder / "A.SpZ", scene).format == "SPZ version 4");
  CHECK(write_scene(folder / "A.x", scene, {.ending = ".SOG"}).format == "SOG version 2");
  CHECK_NOTHROW(require_scene_ending("B.SPLAT"));
  CHECK_THROWS_AS(require_scene_ending("B.PLYX"), std::invalid_argument);
  CHECK(!io::has_ending("ly", ".ply"));
  CHECK(!io::has_ending("a[ply", ".ply"));
}
