// SPDX-License-Identifier: Apache-2.0
#include <numeric>

#include <swiftgs/edit/select.hpp>

#include "scenes.hpp"

namespace swiftgs::test::splat_test {

namespace {

std::string record(vec3 mean, vec3 scale, std::array<int, 8> bytes) {
  std::string out;
  for (const vec3& v : {mean, scale})
    for (int axis = 0; axis < 3; ++axis) append(out, v[axis]);
  for (const int byte : bytes) out += char(byte);
  return out;
}

SceneFile read_splat(const std::string& content) { return read(content, "a.splat"); }

Scene sorted_by_x(const Scene& scene) {
  std::vector<std::uint32_t> order(scene.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](auto a, auto b) { return scene.means[a].x < scene.means[b].x; });
  return subset(scene, order);
}

}  // namespace

TEST_CASE("splat: a record is a Gaussian with linear scales") {
  const SceneFile file = read_splat(record({1, -2, 3}, {0.5f, 2, 0}, {255, 0, 51, 102, 128, 128, 0, 128}));
  const Scene& scene = file.scene;
  REQUIRE(scene.size() == 1);
  CHECK_NOTHROW(validate(scene));
  check_whole(file, ".splat", 1);
  CHECK(scene.means[0] == vec3(1, -2, 3));
  CHECK(scene.scales[0] == vec3(0.5f, 2, 0));
  CHECK(scene.opacities[0] == 0.4f);
  for (int c = 0; c < 3; ++c)
    CHECK(0.5 + 0.28209479177387814 * scene.sh0[0][c] ==
          doctest::Approx(std::array{1.0, 0.0, 0.2}[std::size_t(c)]).epsilon(1e-6));
  CHECK(scene.rotations[0] == Quaternion{0, 0, -1, 0});
  CHECK(scene.sh_degree == 0);
}

TEST_CASE("splat: rotations become unit ones and a quaternion of zeros leaves its Gaussian out") {
  const SceneFile file = read_splat(record({}, {}, {0, 0, 0, 0, 192, 192, 128, 128}) +
                                    record({}, {}, {0, 0, 0, 0, 128, 128, 128, 128}) +
                                    record({}, {}, {0, 0, 0, 0, 128, 128, 127, 128}));
  CHECK(file.left_out.no_rotation == 1);
  REQUIRE(file.scene.size() == 2);
  CHECK(file.scene.rotations[0].w == doctest::Approx(std::sqrt(0.5)));
  CHECK(file.scene.rotations[0].x == doctest::Approx(std::sqrt(0.5)));
  CHECK(file.scene.rotations[1] == Quaternion{0, 0, -1, 0});
}

TEST_CASE("splat: scales below 0 and numbers that are not finite are counted") {
  const SceneFile file =
      read_splat(record({1, 2, 3}, {1, -2, -3}, {}) + record({1, INFINITY, 3}, {1, 2, 3}, {}) +
                 record({1, 2, 3}, {1, 2, NAN}, {}));
  CHECK(file.stored == 3);
  CHECK(file.left_out.not_finite == 2);
  REQUIRE(file.scene.size() == 1);
  CHECK(file.scene.scales[0] == vec3(1, 2, 3));
  REQUIRE(file.notes.size() == 2);
  CHECK(file.notes[0] == "Scales below 0 are taken without their sign, of Gaussians: 1.");
  CHECK(contains(file.notes[1], "Gaussians with a NaN or an infinity are left out: "));
}

TEST_CASE("splat: a last record that is not whole is refused where it begins") {
  const std::string content(96, '\1');
  for (std::size_t size = 0; size <= 96; ++size) {
    const std::string message = complaint_about(content.substr(0, size), "a.splat");
    if (size % 32 == 0)
      CHECK(message == "");
    else
      CHECK(message == "a.splat: byte " + std::to_string(size / 32 * 32) +
                           ": expected records of 32 bytes, as a .splat scene has, found the last one with " +
                           std::to_string(size % 32));
  }
}

TEST_CASE("splat: what is written is read back with every byte rounded to the nearest") {
  Scene scene = some_scene(500, 2);
  for (vec3& colour : scene.sh0) colour *= 0.5f / 0.2821f;
  scene.rotations[0] = {1, 0, 0, 0};
  scene.rotations[1] = {0, 0, 0, -1};
  scene.model.antialiased = true;
  const Written written = write_and_read(scene, ".splat");
  CHECK(written.file.format == ".splat");
  CHECK(written.content.size() == 500 * 32);
  REQUIRE(written.notes.size() == 2);
  CHECK(written.notes[0] ==
        "Harmonics of degree 1 to 2 are left out, 24 coefficients of each of 500 Gaussians.");
  CHECK(contains(written.notes[1], "antialiased"));
  Scene expected = sorted_by_x(scene);
  const Scene found = sorted_by_x(written.scene());
  expected.sh_degree = 0, expected.sh_rest.clear();
  const Difference apart = difference(expected, found);
  CHECK(apart.means == 0);
  CHECK(apart.scales == 0);
  CHECK(apart.opacities <= 0.5 / 255 + 1e-7);
  CHECK(apart.sh0 <= 0.5 / 255 / 0.2820 + 1e-6);
  // Four errors of up to 1/256 turn a unit quaternion by an angle of up to 1/128.
  CHECK(apart.rotations < 2 * std::sin(0.5 / 128));
  for (std::size_t i = 0; i < 500; ++i) {
    if (expected.rotations[i].w == 1) CHECK(std::abs(found.rotations[i].w) == 1);
    if (expected.rotations[i].z == -1) CHECK(std::abs(found.rotations[i].z) == 1);
  }
}

TEST_CASE("splat: large and opaque Gaussians come first") {
  Scene scene = some_scene(300, 0);
  scene.opacities[7] = 1, scene.scales[7] = vec3(100);
  const Scene back = write_and_read(scene, ".splat").scene();
  CHECK(back.means[0] == scene.means[7]);
  const auto size = [&](std::size_t i) {
    const dvec3 scale(back.scales[i]);
    return scale.x * scale.y * scale.z;
  };
  // Opacities are bytes only in the file.
  for (std::size_t i = 1; i < 300; ++i)
    REQUIRE(size(i) * (back.opacities[i] - 0.5 / 255) <= size(i - 1) * (back.opacities[i - 1] + 0.5 / 255));
}

TEST_CASE("splat: colours that a byte cannot hold are counted") {
  Scene scene = some_scene(10, 0);
  for (vec3& colour : scene.sh0) colour *= 0.5f;
  scene.sh0[0] = vec3(2, -2, 0);
  CHECK(write_and_read(scene, ".splat").notes == Strings{"Channels of colours are clamped to 0 to 1: 2."});
  CHECK(write_and_read(Scene(), ".splat").content.empty());
}

}  // namespace swiftgs::test::splat_test
