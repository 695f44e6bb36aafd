// SPDX-License-Identifier: Apache-2.0
#include <stdexcept>

#include "scenes.hpp"

namespace swiftgs::test::spz_write_test {

namespace {

/// Checks that `found` is `scene` to within half a step of every value, on a grid of `grid` for positions.
void check_rounded(const Scene& scene, const Scene& found, double grid = 0x1p-12) {
  const Difference apart = difference(scene, found);
  CHECK(apart.means <= grid / 2);
  CHECK(apart.scales < 0.5 / 16 + 1e-5);
  CHECK(apart.sh0 < 0.5 / 255 / 0.15 + 1e-5);
  CHECK(apart.opacities < 0.5 / 255 + 1e-6);
  // Half a step of three numbers, and what the fourth makes of them.
  CHECK(apart.rotations < 0.0025);
  CHECK(apart.band_1 <= 4 / 128.0);
  CHECK(apart.sh_rest <= 8 / 128.0);
}

}  // namespace

TEST_CASE("spz: what is written is read back to within half a step") {
  for (const int version : {3, 4})
    for (int degree = 0; degree <= 3; ++degree) {
      CAPTURE(version);
      CAPTURE(degree);
      Scene scene = some_scene(300, degree);
      scene.model.antialiased = degree % 2 == 1;
      const Written written = write_and_read(scene, ".spz", {.spz_version = version});
      CHECK(written.file.format == "SPZ version " + std::to_string(version));
      CHECK(written.scene().model.antialiased == scene.model.antialiased);
      CHECK(written.notes.empty());
      check_rounded(scene, written.scene());
    }
}

TEST_CASE("spz: what was read is written as it was in both versions") {
  // Many rotations, so that two components are almost equal in some.
  const Written once = write_and_read(some_scene(20'000, 1), ".spz");
  CHECK(write_and_read(once.scene(), ".spz").content == once.content);
  check_same(write_and_read(once.scene(), ".spz", {.spz_version = 3}).scene(), once.scene());
}

TEST_CASE("spz: a scene of many pieces is whole") {
  const Scene scene = some_scene(300'000, 1), found = write_and_read(scene, ".spz").scene();
  check_same(write_and_read(scene, ".spz", {.spz_version = 3}).scene(), found);
  const double worst = difference(scene, found).means;
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
      std::string stated;
      append(stated, 0xADBE0003), append(stated, 4), append(stated, system);
      if (version == 4) CHECK(content.substr(32, 12) == stated);
      check_same(load_scene(folder / "a.spz"), expected);
      check_same(load_scene(folder / "a.spz", {.spz_frame = frame}), expected);
      CHECK(load_scene(folder / "a.spz", {.spz_frame = SpzFrame::rub}).means != expected.means);
    }
  }
}

TEST_CASE("spz: positions never wrap and the farthest decides how finely they are stored") {
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
    const Written written = write_and_read(scene, ".spz");
    CHECK(written.content[13] == char(bits));
    CHECK(written.notes.size() == (bits < 12 ? 1 : 0));
    check_rounded(scene, written.scene(), std::ldexp(1.0, -bits));
  }
  Scene small = some_scene(20, 0);
  for (vec3& mean : small.means) mean *= 0x1p-9f;
  const Written fine = write_and_read(small, ".spz");
  CHECK(fine.notes.empty());
  CHECK(fine.content[13] == char(21));
  check_rounded(small, fine.scene(), 0x1p-21);
  for (vec3& mean : small.means) mean = vec3(0.0f);
  CHECK(write_and_read(small, ".spz").scene().means == small.means);

  small.means[7] = vec3(8388608.0f, -1e30f, 1);
  const Written far = write_and_read(small, ".spz");
  REQUIRE(far.notes.size() == 2);
  CHECK(contains(far.notes[0], "1/1 instead of 1/4096, because of Gaussians beyond 2048: 1."));
  CHECK(far.notes[1] == "Coordinates are clamped to -8388607 to 8388607: 2.");
  CHECK(far.scene().means[7] == vec3(8388607, -8388607, 1));
}

TEST_CASE("spz: values that the format cannot hold are clamped and counted") {
  Scene scene = some_scene(20, 3);
  scene.sh0[0] = vec3(4, -1e30f, 3.3f);
  scene.scales[1] = vec3(0, 1e30f, 1);
  scene.sh_rest[2] = 1.5f, scene.sh_rest[30] = -2, scene.sh_rest[31] = 1e30f;
  for (const int version : {3, 4}) {
    const Written written =
        write_and_read(scene, ".spz", {.spz_version = version, .spz_frame = SpzFrame::raw});
    CHECK(written.notes == Strings{"SH coefficients of band 0 are clamped to -3.33 to 3.33: 2.",
                                   "Scales are clamped to exp(-10) to exp(5.94): 2.",
                                   "SH coefficients above band 0 are clamped to -1 to 0.99: 3."});
    const Scene& found = written.scene();
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
  const Scene scene = some_scene(50, 0);
  Scene stretched = scene;
  for (Quaternion& q : stretched.rotations) q = {-3 * q.w, -3 * q.x, -3 * q.y, -3 * q.z};
  check_same(write_and_read(scene, ".spz").scene(), write_and_read(stretched, ".spz").scene());
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
  scene.sh_rest[5] = NAN;
  refused(scene, 4, "found 0");
}

}  // namespace swiftgs::test::spz_write_test
