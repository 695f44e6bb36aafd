// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
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

/// Checks the one Gaussian of `plain_gaussian`.
void check_plain(const SceneFile& file) {
  const Scene& scene = file.scene;
  REQUIRE(scene.size() == 1);
  CHECK_NOTHROW(validate(scene));
  CHECK(scene.means[0] == vec3(1, 2, -3));
  CHECK(scene.sh0[0] == vec3(0.25f, -0.5f, 0.75f));
  CHECK(scene.opacities[0] == 0.5f);
  CHECK(scene.scales[0] == vec3(std::exp(-1.0f), std::exp(-2.0f), std::exp(-3.0f)));
  CHECK(scene.rotations[0] == Quaternion{1, 0, 0, 0});
  CHECK(file.stored == 1);
  CHECK(file.dropped_nonfinite == 0);
}

}  // namespace

TEST_CASE("ply: activated values come out of raw ones") {
  const SceneFile file = read(ply(plain_gaussian()));
  check_plain(file);
  CHECK(file.format == "INRIA PLY (binary_little_endian)");
  CHECK(file.notes.empty());
  CHECK(file.scene.sh_degree == 0);
}

TEST_CASE("ply: every encoding holds the same Gaussian") {
  for (const char* format : {"binary_little_endian", "binary_big_endian", "ascii"}) {
    CAPTURE(format);
    check_plain(read(ply(plain_gaussian(), {.format = format})));
  }
}

TEST_CASE("ply: CRLF ends the lines of a header as well as LF") {
  for (const char* format : {"binary_little_endian", "ascii"})
    check_plain(read(ply(plain_gaussian(), {.format = format, .line_break = "\r\n"})));
}

TEST_CASE("ply: every type of both families is understood") {
  for (const char* type : {"char", "int8", "uchar", "uint8", "short", "int16", "ushort", "uint16", "int",
                           "int32", "uint", "uint32", "float", "float32", "double", "float64"}) {
    CAPTURE(type);
    auto gaussian = plain_gaussian();
    for (const char* name : {"x", "y", "opacity"}) property(gaussian, name).type = type;
    for (const char* format : {"binary_little_endian", "binary_big_endian"})
      check_plain(read(ply(gaussian, {.format = format})));
  }
}

TEST_CASE("ply: signed integers keep their sign") {
  for (const char* type : {"char", "short", "int", "double"}) {
    auto gaussian = plain_gaussian();
    property(gaussian, "z").type = type;
    for (const char* format : {"binary_little_endian", "binary_big_endian"})
      check_plain(read(ply(gaussian, {.format = format})));
  }
}

TEST_CASE("ply: properties are found by name whatever surrounds them") {
  auto gaussian = plain_gaussian();
  std::reverse(gaussian.begin(), gaussian.end());
  gaussian.insert(gaussian.begin() + 3, {"uchar", "lod", 7});
  gaussian.insert(gaussian.begin() + 8, {"double", "nx", 9});
  check_plain(read(ply(gaussian)));
}

TEST_CASE("ply: comments and obj_info lines may stand anywhere in the header") {
  check_plain(read(
      ply(plain_gaussian(), {.before = "comment one\nobj_info two three\n\n", .after = "comment last\n"})));
}

TEST_CASE("ply: elements around the vertices are stepped over") {
  std::string list_rows;
  append_value(list_rows, "uchar", 3);
  for (int i = 0; i < 3; ++i) append_value(list_rows, "int", i);
  append_value(list_rows, "float", 1);
  append_value(list_rows, "uchar", 0);
  append_value(list_rows, "float", 2);
  const std::string lists = "element NAME 2\nproperty list uchar int indices\nproperty float weight\n";
  const auto named = [&](const char* name) {
    return std::string(lists).replace(lists.find("NAME"), 4, name);
  };
  check_plain(read(ply(plain_gaussian(), {.before = named("face"),
                                          .before_rows = list_rows,
                                          .after = named("strip"),
                                          .after_rows = list_rows})));

  std::string intrinsics;
  for (int i = 0; i < 2; ++i) append_value(intrinsics, "double", i);
  const std::string plain = "element intrinsic 2\nproperty double value\n";
  check_plain(read(ply(plain_gaussian(), {.after = plain, .after_rows = intrinsics})));
  check_plain(read(ply(plain_gaussian(), {.before = plain, .before_rows = intrinsics})));
}

TEST_CASE("ply: ascii elements around the vertices are stepped over") {
  check_plain(read(ply(plain_gaussian(), {.format = "ascii",
                                          .before = "element face 2\nproperty list uchar int indices\n",
                                          .before_rows = "3 0 1 2\n0\n",
                                          .after = "element camera 1\nproperty float fx\n",
                                          .after_rows = "5.5"})));
}

TEST_CASE("ply: ascii numbers may be signed infinite or not a number") {
  std::string file = ply(plain_gaussian(), {.format = "ascii", .repeat = 2});
  file.replace(file.find("1 2 -3"), 6, "+1 2e0 nan");
  const SceneFile read_back = read(file);
  check_plain({.scene = read_back.scene, .format = "", .stored = 1, .dropped_nonfinite = 0, .notes = {}});
  CHECK(read_back.stored == 2);
  CHECK(read_back.dropped_nonfinite == 1);
}

TEST_CASE("ply: SH coefficients change from channel-major to RGB innermost") {
  for (const int degree : {1, 2, 3, 4}) {
    auto gaussian = plain_gaussian();
    const int count = sh_rest_count(degree);
    for (int i = 0; i < 3 * count; ++i) gaussian.push_back({"float", "f_rest_" + std::to_string(i), i * 0.5});
    const SceneFile file = read(ply(gaussian));
    check_plain(file);
    const int kept = std::min(degree, 3);
    CHECK(file.scene.sh_degree == kept);
    for (int j = 0; j < sh_rest_count(kept); ++j)
      for (int c = 0; c < 3; ++c) CHECK(file.scene.sh_rest[3 * j + c] == float((c * count + j) * 0.5));
    CHECK(file.notes.size() == (degree == 4 ? 1 : 0));
  }
}

TEST_CASE("ply: red green and blue bytes stand in for missing SH coefficients") {
  auto gaussian = plain_gaussian();
  int byte = 0;
  for (const char* name : {"red", "green", "blue"}) gaussian.push_back({"uchar", name, (byte += 85) * 1.0});
  CHECK(read(ply(gaussian)).scene.sh0[0] == vec3(0.25f, -0.5f, 0.75f));  // f_dc wins
  for (const char* name : {"f_dc_0", "f_dc_1", "f_dc_2"}) remove(gaussian, name);
  for (const char* format : {"binary_little_endian", "ascii"}) {
    const vec3 sh0 = read(ply(gaussian, {.format = format})).scene.sh0[0];
    for (int c = 0; c < 3; ++c)
      CHECK(0.5 + 0.28209479177387814 * sh0[c] == doctest::Approx((c + 1) / 3.0).epsilon(1e-6));
  }
}

TEST_CASE("ply: a Gaussian without a third scale is flat") {
  auto gaussian = plain_gaussian();
  remove(gaussian, "scale_2");
  const SceneFile file = read(ply(gaussian));
  CHECK(file.scene.scales[0] == vec3(std::exp(-1.0f), std::exp(-2.0f), 0));
  CHECK(file.notes.size() == 1);
}

TEST_CASE("ply: a comment that says 2D makes Gaussians flat though there is a third scale") {
  const auto read_with = [](const std::string& comments) {
    return read(ply(plain_gaussian(), {.before = comments}));
  };
  const SceneFile flat = read_with("comment SplatRenderMode: 2dgs\n");
  CHECK(flat.scene.scales[0] == vec3(std::exp(-1.0f), std::exp(-2.0f), 0));
  REQUIRE(flat.notes.size() == 1);
  CHECK(flat.notes[0].find("third scale is not used") != std::string::npos);
  const SceneFile solid = read_with("comment SplatRenderMode: 2dgs\ncomment SplatRenderMode: mip\n");
  CHECK(solid.scene.scales[0].z == std::exp(-3.0f));
  CHECK(solid.notes.empty());
}

TEST_CASE("ply: the last comment on the render model counts") {
  const auto antialiased = [](const std::string& comments) {
    return read(ply(plain_gaussian(), {.before = comments})).scene.antialiased;
  };
  CHECK(!antialiased(""));
  CHECK(antialiased("comment SplatRenderMode: mip\n"));
  CHECK(antialiased("comment antialiased 1\n"));
  CHECK(!antialiased("comment antialiased 1\ncomment SplatRenderMode: default\n"));
  CHECK(antialiased("comment antialiased 0\ncomment SplatRenderMode: mip\n"));
  CHECK(!antialiased("comment antialiased 1\ncomment antialiased 0\n"));
}

TEST_CASE("ply: what is not read is noted by name and normals are not") {
  auto gaussian = plain_gaussian();
  for (const char* name : {"nx", "ny", "nz"}) gaussian.push_back({"float", name, 0});
  PlyParts parts{.before = "element empty 0\nproperty list int int vertices\n"};
  CHECK(read(ply(gaussian, parts)).notes.empty());
  gaussian.push_back({"float", "label", 7});
  gaussian.insert(gaussian.begin(), {"uchar", "qual\xffity", 7});
  parts.after = "element camera 2\nproperty char id\nelement face 1\nproperty uchar a\n";
  parts.after_rows = "abc";
  const SceneFile file = read(ply(gaussian, parts));
  check_plain(file);
  REQUIRE(file.notes.size() == 2);
  CHECK(file.notes[0] == "Properties that a scene does not have were not read: qual?ity, label.");
  CHECK(file.notes[1] == "Elements other than Gaussians were not read: camera, face.");
  for (int i = 0; i < 15; ++i) gaussian.push_back({"float", "more_" + std::to_string(i), 0});
  CHECK(contains(read(ply(gaussian, parts)).notes[0], "more_9 and 5 more."));
}

TEST_CASE("ply: a text can be cancelled before all its rows were walked") {
  PlyParts parts{.format = "ascii", .before = "element other 5000000\nproperty int a\n"};
  for (int i = 0; i < 5'000'000; ++i) parts.before_rows += "1\n";
  const std::string whole = ply(plain_gaussian(), parts);
  const std::string damaged = whole.substr(0, whole.size() - 4);
  const auto read_until = [&](const std::string& content, double end) {
    int reports = 0;
    const Progress watch = [&](double part) { return ++reports, part < end; };
    CHECK_THROWS_AS(read_scene(as_bytes(content), "test.ply", {.progress = watch}), Cancelled);
    return reports;
  };
  CHECK(read_until(damaged, 0) == 1);
  CHECK(read_until(damaged, 0.2) > 2);
  double last = 0;
  read_scene(as_bytes(whole), "test.ply", {.progress = [&](double part) { return last = part, true; }});
  CHECK(last == 1);
}

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
