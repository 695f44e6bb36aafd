// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <filesystem>
#include <system_error>

#include <swiftgs/io/scene_file.hpp>

#include "files.hpp"
#include "scenes.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

TEST_CASE("ply: what is written is read back for every degree") {
  const TemporaryFolder folder;
  for (int degree = 0; degree <= 3; ++degree) {
    Scene scene = some_scene(300, degree);
    scene.antialiased = degree % 2 == 1;
    write_scene(folder / "a.ply", scene);
    const SceneFile file = read_scene(folder / "a.ply");
    CHECK(file.dropped_nonfinite == 0);
    CHECK(file.notes.empty());
    REQUIRE(file.scene.size() == scene.size());
    CHECK(file.scene.sh_degree == degree);
    CHECK(file.scene.antialiased == scene.antialiased);
    CHECK(file.scene.means == scene.means);
    CHECK(file.scene.sh0 == scene.sh0);
    CHECK(file.scene.sh_rest == scene.sh_rest);
    for (std::size_t i = 0; i < scene.size(); ++i) {
      CHECK(file.scene.opacities[i] == doctest::Approx(scene.opacities[i]).epsilon(1e-6));
      for (int axis = 0; axis < 3; ++axis)
        CHECK(file.scene.scales[i][axis] == doctest::Approx(scene.scales[i][axis]).epsilon(1e-6));
      const auto expected = covariance(scene, i), found = covariance(file.scene, i);
      const double size = expected[0] + expected[3] + expected[5];
      for (int k = 0; k < 6; ++k) CHECK(std::abs(found[k] - expected[k]) < 2e-6 * size);
    }
  }
}

TEST_CASE("ply: extreme opacities and flat Gaussians survive being written") {
  Scene scene = some_scene(2, 0);
  scene.opacities = {0, 1};
  scene.scales[0] = vec3(1, 2, 0);
  const TemporaryFolder folder;
  write_scene(folder / "a.ply", scene);
  const SceneFile file = read_scene(folder / "a.ply");
  CHECK(file.dropped_nonfinite == 0);
  CHECK(file.scene.opacities[0] == doctest::Approx(1e-6).epsilon(1e-3));
  CHECK(file.scene.opacities[1] == doctest::Approx(1 - 1e-6).epsilon(1e-7));
  CHECK(file.scene.scales[0].z == 0);
}

TEST_CASE("ply: the layout that is written is INRIA's") {
  const TemporaryFolder folder;
  write_scene(folder / "a.ply", some_scene(2, 3));
  const std::string file = content_of(folder / "a.ply");
  std::size_t properties = 0;
  for (std::size_t at = 0; (at = file.find("property float ", at)) != std::string::npos; ++at) ++properties;
  CHECK(properties == 62);
  CHECK(file.size() == file.find("end_header\n") + 11 + 2 * 248);
  CHECK(contains(file, "property float f_rest_44\nproperty float opacity\nproperty float scale_0\n"));
  CHECK(
      contains(file, "z\nproperty float nx\nproperty float ny\nproperty float nz\nproperty float f_dc_0\n"));
}

TEST_CASE("ply: a scene that is not valid or a path that cannot be written is an error") {
  const TemporaryFolder folder;
  Scene scene = some_scene(2, 1);
  CHECK_THROWS_AS(write_scene(folder / "missing" / "a.ply", scene), std::system_error);
  scene.opacities.pop_back();
  CHECK_THROWS_AS(write_scene(folder / "a.ply", scene), std::invalid_argument);
}

TEST_CASE("ply: more Gaussians than are written at once keep their order") {
  const TemporaryFolder folder;
  const Scene scene = some_scene(600'000, 0);
  double last = 0;
  const Progress progress = [&](double part) {
    CHECK(part >= last);
    last = part;
    return true;
  };
  write_scene(folder / "a.ply", scene, {.progress = progress});
  CHECK(last == 1);
  const Scene back = load_scene(folder / "a.ply");
  CHECK(back.means == scene.means);
  CHECK(back.sh0 == scene.sh0);
}
