// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>

#include <swiftgs/io/scene_file.hpp>

#include "ply_text.hpp"
#include "scenes.hpp"
#include "support/ply_numbers.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

SceneFile read(const std::string& content) { return read_scene(as_bytes(content), "test.ply"); }

}  // namespace

TEST_CASE("ply: what is not finite is counted and dropped") {
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               infinity = std::numeric_limits<double>::infinity();
  for (const PlyValue& p : plain_gaussian())
    for (const double bad : {nan, infinity, -infinity}) {
      const bool zero_scale = p.name.starts_with("scale_") && bad == -infinity;
      const bool sure_opacity = p.name == "opacity" && !std::isnan(bad);
      auto gaussian = plain_gaussian();
      property(gaussian, p.name).value = bad;
      const SceneFile file = read(ply(gaussian));
      CAPTURE(p.name);
      CAPTURE(bad);
      CHECK(file.stored == 1);
      CHECK(file.dropped_nonfinite == (zero_scale || sure_opacity ? 0 : 1));
      CHECK(file.scene.size() + file.dropped_nonfinite == 1);
      if (zero_scale) CHECK(file.scene.scales[0][p.name.back() - '0'] == 0);
      if (sure_opacity) CHECK(file.scene.opacities[0] == (bad > 0 ? 1 : 0));
    }
}

TEST_CASE("ply: a scale that overflows when it is activated is dropped") {
  auto gaussian = plain_gaussian();
  property(gaussian, "scale_1").value = 100;
  CHECK(read(ply(gaussian)).dropped_nonfinite == 1);
}

TEST_CASE("ply: dropping keeps the order and all arrays of the others") {
  const Scene original = some_scene(5, 2);
  const TemporaryFolder folder;
  write_scene(folder / "a.ply", original);
  constexpr std::size_t y = 1, some_harmonic = 9 + 7;
  set_ply_number(folder / "a.ply", 5, 1, y, std::numeric_limits<float>::quiet_NaN());
  set_ply_number(folder / "a.ply", 5, 3, some_harmonic, std::numeric_limits<float>::infinity());
  const SceneFile file = read_scene(folder / "a.ply");
  CHECK(file.dropped_nonfinite == 2);
  REQUIRE(file.scene.size() == 3);
  CHECK_NOTHROW(validate(file.scene));
  const std::size_t kept[] = {0, 2, 4};
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(file.scene.means[i] == original.means[kept[i]]);
    CHECK(file.scene.sh0[i] == original.sh0[kept[i]]);
    for (std::size_t k = 0; k < 24; ++k)
      CHECK(file.scene.sh_rest[i * 24 + k] == original.sh_rest[kept[i] * 24 + k]);
  }
}

TEST_CASE("ply: a zero quaternion is the identity and any other becomes a unit one") {
  auto gaussian = plain_gaussian();
  property(gaussian, "rot_0").value = 0;
  CHECK(read(ply(gaussian)).scene.rotations[0] == Quaternion{1, 0, 0, 0});
  property(gaussian, "rot_0").value = 3e30;
  property(gaussian, "rot_3").value = -4e30;
  const Quaternion q = read(ply(gaussian)).scene.rotations[0];
  CHECK(q.w == doctest::Approx(0.6));
  CHECK(q.z == doctest::Approx(-0.8));
}

TEST_CASE("ply: a file without Gaussians is an empty scene") {
  for (const char* format : {"binary_little_endian", "ascii"}) {
    const SceneFile file = read(ply(plain_gaussian(), {.format = format, .repeat = 0}));
    CHECK(file.stored == 0);
    CHECK(file.scene.size() == 0);
  }
}
