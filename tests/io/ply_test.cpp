// SPDX-License-Identifier: Apache-2.0
#include <system_error>
#include <utility>

#include <swiftgs/edit/order.hpp>

#include "ply_text.hpp"
#include "scenes.hpp"
#include "support/ply_numbers.hpp"

namespace swiftgs::test::ply_test {

TEST_CASE("ply: every encoding and line break hold the same Gaussian, or none") {
  for (const char* format : ply_formats)
    for (const char* line_break : {"\n", "\r\n"}) {
      CAPTURE(format);
      PlyParts parts{.format = format, .line_break = line_break};
      const SceneFile file = read(ply(plain_gaussian(), parts));
      check_plain(file);
      check_whole(file, "INRIA PLY (" + std::string(format) + ")", 1);
      CHECK(file.scene.sh_degree == 0);
      parts.repeat = 0;
      const SceneFile none = read(ply(plain_gaussian(), parts));
      CHECK(none.stored == 0);
      CHECK(none.scene.size() == 0);
    }
}

// Exporters pad lines with blanks, editors of Windows write a byte order mark.
TEST_CASE("ply: blanks at the ends of header lines and a byte order mark change nothing") {
  for (const char* format : ply_formats)
    for (const std::string line_break : {" \n", "\t \n", "  \r\n"})
      for (const std::string mark : {"", "\xef\xbb\xbf"})
        check_plain(read(mark + ply(plain_gaussian(), {.format = format, .line_break = line_break})));
  // Places count the mark.
  CHECK(complaint_about("\xef\xbb\xbfply\nelement") ==
        "a file: byte 7: expected a 'format' line before the first element");
}

TEST_CASE("ply: every type of both families is understood and signed ones keep their sign") {
  for (const std::string type : {"char", "int8", "uchar", "uint8", "short", "int16", "ushort", "uint16",
                                 "int", "int32", "uint", "uint32", "float", "float32", "double", "float64"}) {
    CAPTURE(type);
    auto gaussian = plain_gaussian();
    for (const char* name : {"x", "y", "z", "opacity"})
      if (name[0] != 'z' || type[0] != 'u') property(gaussian, name).type = type;
    for (const char* format : {"binary_little_endian", "binary_big_endian"})
      check_plain(read(ply(gaussian, {.format = format})));
  }
}

TEST_CASE("ply: elements, comments and obj_info lines around the vertices are stepped over") {
  std::string list_rows, intrinsics;
  append_value(list_rows, "uchar", 3);
  for (int i = 0; i < 3; ++i) append_value(list_rows, "int", i);
  append_value(list_rows, "float", 1), append_value(list_rows, "uchar", 0),
      append_value(list_rows, "float", 2);
  for (int i = 0; i < 2; ++i) append_value(intrinsics, "double", i);
  const std::string lists = "element NAME 2\nproperty list uchar int indices\nproperty float weight\n";
  const std::string faces = with(lists, "NAME", "face"), strips = with(lists, "NAME", "strip");
  const std::string plain = "element intrinsic 2\nproperty double value\n";
  for (const PlyParts& parts :
       {PlyParts{.before = "comment one\nobj_info two three\n\n", .after = "comment last\n"},
        PlyParts{.before = faces, .before_rows = list_rows, .after = strips, .after_rows = list_rows},
        PlyParts{.after = plain, .after_rows = intrinsics},
        PlyParts{.before = plain, .before_rows = intrinsics},
        PlyParts{.format = "ascii",
        .before = "element face 2\nproperty list uchar int indices\n",
        .before_rows = "3 0 1 2\n0\n",
        .after = "element camera 1\nproperty float fx\n",
        .after_rows = "5.5"}})
    check_plain(read(ply(plain_gaussian(), parts)));
}

TEST_CASE("ply: ascii numbers may be signed infinite or not a number") {
  SceneFile file =
      read(with(ply(plain_gaussian(), {.format = "ascii", .repeat = 2}), "1 2 -3", "+1 2e0 nan"));
  CHECK(std::exchange(file.stored, 1) == 2);
  CHECK(std::exchange(file.left_out.not_finite, 0) == 1);
  check_plain(file);
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

// nerfstudio 1.1.5, ns-export gaussian-splat --ply-color-mode rgb.
TEST_CASE("ply: red green and blue bytes stand in for missing SH coefficients") {
  auto gaussian = plain_gaussian();
  int byte = 0;
  for (const char* name : {"red", "green", "blue"}) gaussian.push_back({"uchar", name, (byte += 85) * 1.0});
  CHECK(read(ply(gaussian)).scene.sh0[0] == vec3(0.25f, -0.5f, 0.75f));  // f_dc wins
  for (const char* name : {"f_dc_0", "f_dc_1", "f_dc_2"}) remove(gaussian, name);
  for (const char* format : ply_formats) {
    const std::string before = "comment Generated by Nerstudio 1.1.5\ncomment Vertical Axis: z\n";
    const SceneFile file = read(ply(gaussian, {.format = format, .before = before}));
    CHECK(file.notes.empty());
    for (int c = 0; c < 3; ++c)
      CHECK(0.5 + 0.28209479177387814 * file.scene.sh0[0][c] == doctest::Approx((c + 1) / 3.0).epsilon(1e-6));
  }
}

TEST_CASE("ply: a Gaussian without a third scale is flat") {
  auto gaussian = plain_gaussian();
  remove(gaussian, "scale_2");
  const SceneFile file = read(ply(gaussian));
  CHECK(file.scene.scales[0] == vec3(std::exp(-1.0f), std::exp(-2.0f), 0));
  CHECK(file.notes.size() == 1);
}

TEST_CASE("ply: the last comment on the render model counts and a third scale is not used in 2D") {
  const std::string mip = "comment SplatRenderMode: mip\n", flat = "comment SplatRenderMode: 2dgs\n",
                    on = "comment antialiased 1\n", off = "comment antialiased 0\n",
                    usual = "comment SplatRenderMode: default\n";
  const std::pair<std::string, bool> cases[] = {
      {"", false},         {mip, true},        {on, true},
      {on + usual, false}, {off + mip, true},  {on + off, false},
      {flat, false},       {flat + mip, true}, {"comment splatrendermode: MIP\n", true}};
  for (const auto& [comments, antialiased] : cases) {
    CAPTURE(comments);
    const SceneFile file = read(ply(plain_gaussian(), {.before = comments}));
    CHECK(file.scene.model.antialiased == antialiased);
    CHECK(file.scene.scales[0] ==
          vec3(std::exp(-1.0f), std::exp(-2.0f), comments == flat ? 0 : std::exp(-3.0f)));
    CHECK((file.scene.model.kernel == RenderingModel::Kernel::disk) == (comments == flat));
    REQUIRE(file.notes.size() == (comments == flat ? 2 : 0));
    if (comments == flat)
      CHECK(contains(all_notes(file.notes), "third scale of the Gaussians, which are flat, is not used"));
  }
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
    CHECK_THROWS_AS(read(content, "a.ply", {.progress = watch}), Cancelled);
    return reports;
  };
  CHECK(read_until(damaged, 0) == 1);
  CHECK(read_until(damaged, 0.2) > 2);
  double last = 0;
  read(whole, "a.ply", {.progress = [&](double part) { return last = part, true; }});
  CHECK(last == 1);
}

TEST_CASE("ply: what is not finite is counted and dropped") {
  for (const PlyValue& p : plain_gaussian())
    for (const double bad : {double(NAN), double(INFINITY), -double(INFINITY)}) {
      const bool zero_scale = p.name.starts_with("scale_") && bad < 0;
      const bool sure_opacity = p.name == "opacity" && !std::isnan(bad);
      auto gaussian = plain_gaussian();
      property(gaussian, p.name).value = bad;
      const SceneFile file = read(ply(gaussian));
      CAPTURE(p.name);
      CAPTURE(bad);
      CHECK(file.stored == 1);
      CHECK(file.left_out.not_finite == (zero_scale || sure_opacity ? 0 : 1));
      CHECK(file.scene.size() + file.left_out.not_finite == 1);
      if (zero_scale) CHECK(file.scene.scales[0][p.name.back() - '0'] == 0);
      if (sure_opacity) CHECK(file.scene.opacities[0] == (bad > 0 ? 1 : 0));
    }
  auto overflowing = plain_gaussian();
  property(overflowing, "scale_1").value = 100;  // before it is activated
  CHECK(read(ply(overflowing)).left_out.not_finite == 1);
}

TEST_CASE("ply: dropping keeps the order and all arrays of the others") {
  const Scene original = some_scene(5, 2);
  const TemporaryFolder folder;
  write_scene(folder / "a.ply", original);
  constexpr std::size_t y = 1, some_harmonic = 9 + 7;
  set_ply_number(folder / "a.ply", 5, 1, y, NAN);
  set_ply_number(folder / "a.ply", 5, 3, some_harmonic, INFINITY);
  const SceneFile file = read_scene(folder / "a.ply");
  CHECK(file.left_out.not_finite == 2);
  const Scene kept = subset(original, {0, 2, 4});
  CHECK(difference(kept, file.scene).means == 0);
  CHECK(file.scene.sh0 == kept.sh0);
  CHECK(file.scene.sh_rest == kept.sh_rest);
}

TEST_CASE("ply: a quaternion of zeros leaves its Gaussian out and any other becomes a unit one") {
  for (const char* format : ply_formats)
    for (const std::string type : {"float", "double"}) {
      CAPTURE(format);
      CAPTURE(type);
      auto gaussian = plain_gaussian();
      for (const char* name : {"rot_0", "rot_1", "rot_2", "rot_3"})
        property(gaussian, name) = {type, name, 0};
      property(gaussian, "rot_2").value = -0.0;
      const SceneFile none = read(ply(gaussian, {.format = format, .repeat = 3}));
      CHECK(none.left_out.no_rotation == 3);
      CHECK(none.left_out.not_finite == 0);
      CHECK(none.scene.size() == 0);
      CHECK(none.stored == 3);
      CHECK(none.notes == Strings{"Gaussians whose quaternion is no rotation are left out: 3."});
      // The last two lengths are zero and infinite as floats.
      std::vector<double> lengths = {1e-37, 1e-20, 5, 5e30};
      if (type == "double") lengths.insert(lengths.end(), {1e-60, 1e200});
      for (const double length : lengths) {
        CAPTURE(length);
        property(gaussian, "rot_0").value = 0.6 * length, property(gaussian, "rot_3").value = -0.8 * length;
        const SceneFile file = read(ply(gaussian, {.format = format}));
        REQUIRE(file.scene.size() == 1);
        CHECK(file.scene.rotations[0].w == doctest::Approx(0.6));
        CHECK(file.scene.rotations[0].z == doctest::Approx(-0.8));
      }
    }
}

TEST_CASE("ply: rows of zeros are left out and counted apart from what is not finite") {
  const std::string content = ply(plain_gaussian(), {.repeat = 4});
  constexpr std::size_t row = 14 * sizeof(float);
  const std::size_t rows = content.size() - 4 * row;
  std::string holes = content;
  for (const std::size_t i : {0, 2}) holes.replace(rows + i * row, row, std::string(row, '\0'));
  SceneFile file = read(with(holes, rows + 2 * row, float(NAN)));
  CHECK(std::exchange(file.left_out, {}).no_rotation == 1);
  CHECK(file.notes == Strings{"Gaussians with a NaN or an infinity are left out: 1.",
                              "Gaussians whose quaternion is no rotation are left out: 1."});
  CHECK(file.scene.means == std::vector<vec3>(2, vec3(1, 2, -3)));
}

TEST_CASE("ply: what is written is read back for every degree") {
  for (int degree = 0; degree <= 3; ++degree) {
    Scene scene = some_scene(300, degree);
    scene.model.antialiased = degree % 2 == 1;
    scene.opacities[0] = 0, scene.opacities[1] = 1;
    scene.scales[0] = vec3(1, 2, 0);
    const Scene found = write_and_read(scene, ".ply").scene();
    CHECK(found.model.antialiased == scene.model.antialiased);
    CHECK(found.means == scene.means);
    CHECK(found.sh0 == scene.sh0);
    CHECK(found.sh_rest == scene.sh_rest);
    CHECK(found.opacities[0] == doctest::Approx(1e-6).epsilon(1e-3));
    CHECK(found.opacities[1] == doctest::Approx(1 - 1e-6).epsilon(1e-7));
    const Difference apart = difference(scene, found);
    CHECK(apart.opacities < 1.1e-6);
    CHECK(apart.scales < 1e-6);
    CHECK(apart.rotations < 5e-7);
  }
}

TEST_CASE("ply: the layout that is written is INRIA's") {
  const std::string file = write_and_read(some_scene(2, 3), ".ply").content;
  std::size_t properties = 0;
  for (std::size_t at = 0; (at = file.find("property float ", at)) != std::string::npos; ++at) ++properties;
  CHECK(properties == 62);
  CHECK(file.size() == file.find("end_header\n") + 11 + 2 * 248);
  CHECK(contains(file, "property float f_rest_44\nproperty float opacity\nproperty float scale_0\n"));
  CHECK(contains(file, "z\nproperty float nx\nproperty float ny\nproperty float nz\nproperty float f_dc"));
}

TEST_CASE("ply: a scene that is not valid or a path that cannot be written is an error") {
  const TemporaryFolder folder;
  Scene scene = some_scene(2, 1);
  CHECK_THROWS_AS(write_scene(folder / "missing" / "a.ply", scene), std::system_error);
  scene.opacities.pop_back();
  CHECK_THROWS_AS(write_scene(folder / "a.ply", scene), std::invalid_argument);
}

TEST_CASE("ply: more Gaussians than are written or read at once keep their order") {
  const Scene scene = some_scene(600'000, 0);
  const Scene found = write_and_read(scene, ".ply").scene();
  CHECK(found.means == scene.means);
  CHECK(found.sh0 == scene.sh0);
}

TEST_CASE("ply: properties are found by name whatever surrounds them") {
  auto gaussian = plain_gaussian();
  std::reverse(gaussian.begin(), gaussian.end());
  gaussian.insert(gaussian.begin() + 3, {"uchar", "lod", 7});
  gaussian.insert(gaussian.begin() + 8, {"double", "nx", 9});
  check_plain(read(ply(gaussian)));
}

}  // namespace swiftgs::test::ply_test
