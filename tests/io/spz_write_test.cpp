// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>
#include <stdexcept>

#include <swiftgs/io/scene_file.hpp>

#include "scenes.hpp"
#include "spz_encoder.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

double rotation_error(const Quaternion& a, const Quaternion& b) {
  const double dot = a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z, sign = dot < 0 ? -1 : 1;
  return std::hypot(std::hypot(a.w - sign * b.w, a.x - sign * b.x),
                    std::hypot(a.y - sign * b.y, a.z - sign * b.z));
}

/// Checks that `found` is `scene` to within half a step of every value, on a grid of `grid` for positions.
void check_rounded(const Scene& scene, const Scene& found, double grid = 0x1p-12) {
  const std::size_t rest = 3 * std::size_t(sh_rest_count(scene.sh_degree));
  REQUIRE(found.size() == scene.size());
  REQUIRE(found.sh_degree == scene.sh_degree);
  for (std::size_t i = 0; i < scene.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      CHECK(std::abs(double(found.means[i][axis]) - double(scene.means[i][axis])) <= grid / 2);
      CHECK(std::abs(std::log(found.scales[i][axis] / scene.scales[i][axis])) < 0.5 / 16 + 1e-5);
      CHECK(std::abs(found.sh0[i][axis] - scene.sh0[i][axis]) < 0.5 / 255 / 0.15 + 1e-5);
    }
    CHECK(std::abs(found.opacities[i] - scene.opacities[i]) < 0.5 / 255 + 1e-6);
    // Half a step of three numbers, and what the fourth makes of them.
    CHECK(rotation_error(found.rotations[i], scene.rotations[i]) < 0.0025);
    for (std::size_t k = 0; k < rest; ++k)
      CHECK(std::abs(found.sh_rest[i * rest + k] - scene.sh_rest[i * rest + k]) <= (k < 9 ? 4 : 8) / 128.0);
  }
}

void check_same(const Scene& a, const Scene& b) {
  CHECK(a.means == b.means);
  CHECK(a.scales == b.scales);
  // The sign of a quaternion means nothing.
  for (std::size_t i = 0; i < a.size(); ++i) REQUIRE(rotation_error(a.rotations[i], b.rotations[i]) < 1e-6);
  CHECK(a.opacities == b.opacities);
  CHECK(a.sh0 == b.sh0);
  CHECK(a.sh_rest == b.sh_rest);
}

std::string little_endian(std::uint32_t value) {
  std::string raw;
  append(raw, value);
  return raw;
}

}  // namespace

TEST_CASE("spz: what is written is read back to within half a step") {
  const TemporaryFolder folder;
  for (const int version : {3, 4})
    for (int degree = 0; degree <= 3; ++degree) {
      CAPTURE(version);
      CAPTURE(degree);
      Scene scene = some_scene(300, degree);
      scene.antialiased = degree % 2 == 1;
      const WrittenScene written = write_scene(folder / "a.spz", scene, {.spz_version = version});
      CHECK(written.format == "SPZ version " + std::to_string(version));
      CHECK(written.bytes == content_of(folder / "a.spz").size());
      CHECK(written.notes.empty());
      const SceneFile file = read_scene(folder / "a.spz");
      CHECK(file.format == written.format);
      CHECK(file.scene.antialiased == scene.antialiased);
      CHECK(file.notes.empty());
      check_rounded(scene, file.scene);
    }
}

TEST_CASE("spz: what was read is written as it was in both versions") {
  const TemporaryFolder folder;
  // Many rotations, so that two components are almost equal in some.
  write_scene(folder / "a.spz", some_scene(20'000, 1));
  const Scene scene = load_scene(folder / "a.spz");
  write_scene(folder / "b.spz", scene);
  CHECK(content_of(folder / "b.spz") == content_of(folder / "a.spz"));
  write_scene(folder / "c.spz", scene, {.spz_version = 3});
  check_same(load_scene(folder / "c.spz"), scene);
}

TEST_CASE("spz: a scene of many pieces is whole") {
  const TemporaryFolder folder;
  const Scene scene = some_scene(300'000, 1);
  write_scene(folder / "4.spz", scene);
  write_scene(folder / "3.spz", scene, {.spz_version = 3});
  const Scene found = load_scene(folder / "4.spz");
  check_same(load_scene(folder / "3.spz"), found);
  double worst = 0;
  for (std::size_t i = 0; i < scene.size(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      worst = std::max(worst, std::abs(double(found.means[i][axis]) - double(scene.means[i][axis])));
  CHECK(worst <= 0x1p-13);
  CHECK(worst > 0x1p-14);
}

TEST_CASE("spz: a file says which axes it holds unless they are the format's own") {
  const TemporaryFolder folder;
  const Scene scene = some_scene(20, 3);
  for (const int version : {3, 4}) {
    const auto write = [&](const char* name, SpzFrame frame) {
      write_scene(folder / name, scene, {.spz_version = version, .spz_frame = frame});
      return content_of(folder / name);
    };
    const std::string rub = write("rub.spz", SpzFrame::rub);
    CHECK(rub == write("specified.spz", SpzFrame::specified));
    const Scene expected = load_scene(folder / "rub.spz");
    for (const auto& [frame, system] :
         {std::pair{SpzFrame::rdf, 6u}, {SpzFrame::raw, 6u}, {SpzFrame::luf, 7u}}) {
      const std::string content = write("a.spz", frame);
      CHECK(content != rub);
      if (version == 4)
        CHECK(content.substr(32, 12) == little_endian(0xADBE0003) + little_endian(4) + little_endian(system));
      check_same(load_scene(folder / "a.spz"), expected);
      check_same(load_scene(folder / "a.spz", {.spz_frame = frame}), expected);
      CHECK(load_scene(folder / "a.spz", {.spz_frame = SpzFrame::rub}).means != expected.means);
    }
  }
}

TEST_CASE("spz: positions never wrap and the farthest decides how finely they are stored") {
  const TemporaryFolder folder;
  // 2^23 - 1 is the largest number; the last has to be clamped.
  for (const auto& [far, bits] : {std::pair{2047.9f, 12},
                                  {2048.0f, 11},
                                  {-5000.0f, 10},
                                  {1e6f, 3},
                                  {8388607.0f, 0},
                                  {-8388607.0f, 0}}) {
    CAPTURE(far);
    Scene scene = some_scene(20, 0);
    scene.means[7].y = far;
    const WrittenScene written = write_scene(folder / "a.spz", scene);
    CHECK(content_of(folder / "a.spz")[13] == char(bits));
    CHECK(written.notes.size() == (bits < 12 ? 1 : 0));
    check_rounded(scene, load_scene(folder / "a.spz"), std::ldexp(1.0, -bits));
  }
  Scene small = some_scene(20, 0);
  for (vec3& mean : small.means) mean *= 0x1p-9f;
  CHECK(write_scene(folder / "a.spz", small).notes.empty());
  CHECK(content_of(folder / "a.spz")[13] == char(21));
  check_rounded(small, load_scene(folder / "a.spz"), 0x1p-21);
  for (vec3& mean : small.means) mean = vec3(0.0f);
  write_scene(folder / "a.spz", small);
  CHECK(load_scene(folder / "a.spz").means == small.means);

  Scene scene = some_scene(20, 0);
  scene.means[7] = vec3(8388608.0f, -1e30f, 1);
  const WrittenScene written = write_scene(folder / "a.spz", scene);
  REQUIRE(written.notes.size() == 2);
  CHECK(contains(written.notes[0], "1/1 instead of 1/4096, because of Gaussians beyond 2048: 1."));
  CHECK(written.notes[1] == "Coordinates are clamped to -8388607 to 8388607: 2.");
  CHECK(load_scene(folder / "a.spz").means[7] == vec3(8388607, -8388607, 1));
}

TEST_CASE("spz: values that the format cannot hold are clamped and counted") {
  const TemporaryFolder folder;
  Scene scene = some_scene(20, 3);
  scene.sh0[0] = vec3(4, -1e30f, 3.3f);
  scene.scales[1] = vec3(0, 1e30f, 1);
  scene.sh_rest[2] = 1.5f, scene.sh_rest[30] = -2, scene.sh_rest[31] = 1e30f;
  for (const int version : {3, 4}) {
    const WrittenScene written =
        write_scene(folder / "a.spz", scene, {.spz_version = version, .spz_frame = SpzFrame::raw});
    REQUIRE(written.notes.size() == 3);
    CHECK(written.notes[0] == "SH coefficients of band 0 are clamped to -3.33 to 3.33: 2.");
    CHECK(written.notes[1] == "Scales are clamped to exp(-10) to exp(5.94): 2.");
    CHECK(written.notes[2] == "SH coefficients above band 0 are clamped to -1 to 0.99: 3.");
    const Scene found = load_scene(folder / "a.spz");
    CHECK(found.sh0[0].x == doctest::Approx(0.5 / 0.15));
    CHECK(found.sh0[0].y == doctest::Approx(-0.5 / 0.15));
    CHECK(found.scales[1].x == doctest::Approx(std::exp(-10.0)));
    CHECK(found.scales[1].y == doctest::Approx(std::exp(255 / 16.0 - 10)));
    CHECK(found.sh_rest[2] == 127.0f / 128);
    CHECK(found.sh_rest[30] == -1);
    CHECK(found.sh_rest[31] == 127.0f / 128);
  }
}

TEST_CASE("spz: values that are rounded to the last byte are not counted as clamped") {
  const TemporaryFolder folder;
  Scene scene = some_scene(20, 1);
  const SceneWriteOptions as_stored{.spz_frame = SpzFrame::raw};  // other axes flip signs of coefficients
  // Bytes of 255.4 and -0.4; below of 255.6 and -0.6, which are beyond half a step.
  const auto colour_of = [](float byte) { return (byte - 127.5f) / (0.15f * 255); };
  const auto scale_of = [](float byte) { return std::exp(byte / 16 - 10); };
  scene.sh0[0] = vec3(colour_of(255.4f), colour_of(-0.4f), 0);
  scene.scales[0] = vec3(scale_of(255.4f), scale_of(-0.4f), 1);
  scene.sh_rest[0] = 127.4f / 128, scene.sh_rest[1] = -128.4f / 128;
  CHECK(write_scene(folder / "a.spz", scene, as_stored).notes.empty());
  scene.sh0[1] = vec3(colour_of(255.6f), colour_of(-0.6f), 0);
  scene.scales[1] = vec3(scale_of(255.6f), scale_of(-0.6f), 1);
  scene.sh_rest[2] = 127.6f / 128, scene.sh_rest[3] = -128.6f / 128;
  const WrittenScene written = write_scene(folder / "a.spz", scene, as_stored);
  REQUIRE(written.notes.size() == 3);
  for (const std::string& note : written.notes) CHECK(note.ends_with(": 2."));
}

TEST_CASE("spz: rotations of any length and sign are written as what they turn by") {
  const TemporaryFolder folder;
  const Scene scene = some_scene(50, 0);
  Scene stretched = scene;
  for (Quaternion& q : stretched.rotations) q = {-3 * q.w, -3 * q.x, -3 * q.y, -3 * q.z};
  write_scene(folder / "a.spz", scene);
  write_scene(folder / "b.spz", stretched);
  check_same(load_scene(folder / "a.spz"), load_scene(folder / "b.spz"));
}

TEST_CASE("spz: what cannot be a file is refused before there is one") {
  const TemporaryFolder folder;
  const auto refused = [&](const Scene& scene, int version, const char* why) {
    CHECK_THROWS_WITH_AS(write_scene(folder / "a.spz", scene, {.spz_version = version}),
                         doctest::Contains(why), std::invalid_argument);
    CHECK(std::filesystem::is_empty(folder.path()));
  };
  for (const int version : {-1, 2, 5}) refused(some_scene(2, 0), version, "version 3 or 4");
  refused({}, 4, "1 to 2147483647 Gaussians");
  Scene scene = some_scene(1, 1);
  scene.sh_rest[5] = std::numeric_limits<float>::quiet_NaN();
  refused(scene, 4, "found 0");
}
