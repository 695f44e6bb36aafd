// SPDX-License-Identifier: Apache-2.0
/// @file
/// Files as public programs lay them out, put together here; each test names program and version.
#include "compressed_ply_text.hpp"
#include "ply_text.hpp"
#include "scenes.hpp"

namespace swiftgs::test::layouts_test {

namespace {

/// An element with one property of its own name, as SHARP's files have them.
struct Extra {
  std::string type, name;
  std::vector<double> values;
};

std::string with_extras(const std::vector<Extra>& extras, const std::string& format) {
  PlyParts parts{.format = format};
  for (const Extra& extra : extras) {
    parts.after += "element " + extra.name + " " + std::to_string(extra.values.size()) + "\nproperty " +
                   extra.type + " " + extra.name + "\n";
    for (const double value : extra.values)
      if (format == "ascii")
        parts.after_rows += std::to_string(value) + "\n";
      else
        append_value(parts.after_rows, extra.type, value, format == "binary_big_endian");
  }
  return ply(plain_gaussian(), parts);
}

const std::vector<double> identity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

/// What SHARP 1.5.0 writes for a photograph of 48x32 pixels.
std::vector<Extra> sharp_extras() {
  return {{"float", "extrinsic", identity},   {"float", "intrinsic", {40, 0, 24, 0, 40, 16, 0, 0, 1}},
          {"uint", "image_size", {48, 32}},   {"int", "frame", {1, 1}},
          {"float", "disparity", {0.3, 0.4}}, {"uchar", "color_space", {0}},
          {"uchar", "version", {1, 5, 0}}};
}

}  // namespace

// Mip-Splatting, save_ply at 24af724 (2024), and RaDe-GS at 4e87e2f, which took it over.
TEST_CASE("layouts: the 3D filter of Mip-Splatting grows scales and dims opacities") {
  auto gaussian = plain_gaussian();
  gaussian.push_back({"float", "filter_3D", 0.25});
  for (const char* format : ply_formats) {
    const SceneFile file = read(ply(gaussian, {.format = format}));
    double kept = 1;
    for (int axis = 0; axis < 3; ++axis) {
      const double before = std::exp(-1.0 - axis), after = std::sqrt(before * before + 0.0625);
      CHECK(file.scene.scales[0][axis] == doctest::Approx(after).epsilon(1e-6));
      kept *= before / after;
    }
    CHECK(file.scene.opacities[0] == doctest::Approx(0.5 * kept).epsilon(1e-6));
    CHECK(contains(all_notes(file.notes), "(filter_3D) is applied to scales and opacities"));
    CHECK(!contains(all_notes(file.notes), "not read"));
  }
  property(gaussian, "filter_3D").value = 0;  // as RaDe-GS resets it
  check_plain(read(ply(gaussian)));
  // Of flat Gaussians the factor of the axis without extent would be 0.
  property(gaussian, "filter_3D").value = 0.25;
  remove(gaussian, "scale_2");
  const SceneFile flat = read(ply(gaussian));
  CHECK(flat.scene.scales[0].z == 0);
  CHECK(flat.scene.opacities[0] > 0.1f);
}

// Apple's ml-sharp, save_ply at 1390830, version 1.5.0.
TEST_CASE("layouts: the camera of SHARP's photograph is read") {
  for (const char* format : ply_formats) {
    const SceneFile file = read(with_extras(sharp_extras(), format));
    check_plain(file);
    REQUIRE(file.camera);
    const Camera& camera = *file.camera;
    CHECK(std::vector{camera.width, camera.height} == std::vector{48, 32});
    CHECK(std::vector{camera.fx, camera.cx, camera.cy} == std::vector<double>{40, 24, 16});
    CHECK(camera.rotation == dmat3(1.0));
    CHECK(file.notes == Strings{"The file holds the camera of its photograph, of 48x32 pixels."});
  }
  // A quarter turn about z and a step: the matrix is stored by rows.
  std::vector<Extra> turned = sharp_extras();
  turned[0].values = {0, -1, 0, 5, 1, 0, 0, 6, 0, 0, 1, 7, 0, 0, 0, 1};
  const SceneFile file = read(with_extras(turned, "binary_little_endian"));
  REQUIRE(file.camera);
  CHECK(file.camera->rotation * dvec3(1, 0, 0) == dvec3(0, 1, 0));
  CHECK(file.camera->translation == dvec3(5, 6, 7));
}

// What ml-sharp's load_ply calls legacy: twelve numbers with the rotation by columns, and four of the camera.
TEST_CASE("layouts: the camera of an early SHARP is read") {
  const SceneFile file = read(with_extras({{"float", "extrinsic", {0, 1, 0, 5, -1, 0, 0, 6, 0, 0, 1, 7}},
                                           {"float", "intrinsic", {500, 501, 640, 480}}},
                                          "binary_little_endian"));
  REQUIRE(file.camera);
  CHECK(file.camera->rotation * dvec3(1, 0, 0) == dvec3(0, 1, 0));
  CHECK(file.camera->translation == dvec3(5, 6, 7));
  CHECK(file.camera->fy == 501);
  CHECK(file.camera->width == 640);
  CHECK(file.camera->cy == 240);
}

// ml-sharp before it converted colours for other programs: color_space 1 is linear.
TEST_CASE("layouts: linear colours of SHARP become sRGB with or without a camera") {
  std::vector<Extra> extras = sharp_extras();
  extras[5].values = {1};
  for (const bool camera : {true, false}) {
    if (!camera) extras.erase(extras.begin(), extras.begin() + 3);
    const SceneFile file = read(with_extras(extras, "binary_little_endian"));
    CHECK(file.camera.has_value() == camera);
    const double c0 = 0.28209479177387814, linear = 0.5 + c0 * 0.25;
    const double srgb = 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
    CHECK(file.scene.sh0[0].x == doctest::Approx((srgb - 0.5) / c0).epsilon(1e-6));
    CHECK(contains(all_notes(file.notes), "The colours are linear (color_space) and become sRGB."));
  }
}

TEST_CASE("layouts: a camera that is none is noted and refuses nothing") {
  for (const std::size_t changed : {0, 1, 2}) {
    std::vector<Extra> extras = sharp_extras();
    extras[changed].values = {0, 0};
    check_plain(read(with_extras(extras, "binary_little_endian")));
    extras[5].values = {1};  // linear colours become sRGB all the same
    const SceneFile file = read(with_extras(extras, "binary_little_endian"));
    CHECK(file.scene.sh0[0].x > 0.3f);
    CHECK(!file.camera);
    CHECK(contains(all_notes(file.notes), "were not read: extrinsic, intrinsic, "));
  }
}

// CloudCompare 2.13 saves scalar fields so, and 3dgsconverter 0.7 wrote `scal_` for it; colours are added.
TEST_CASE("layouts: names with the prefix of CloudCompare are those of Gaussians") {
  for (const std::string prefix : {"scalar_", "scal_", "scalar_scal_"}) {
    auto gaussian = plain_gaussian();
    for (PlyValue& value : gaussian)
      if (value.name.size() > 1) value.name.insert(0, prefix);
    gaussian.insert(gaussian.begin() + 3,
                    {{"uchar", "red", 1}, {"uchar", "green", 2}, {"uchar", "blue", 3}, {"float", "nx", 0}});
    const SceneFile file = read(ply(gaussian));
    check_plain(file);
    CHECK(file.notes == Strings{"Properties that a scene does not have were not read: red, green, blue."});
  }
  auto both = plain_gaussian();
  both.push_back({"float", "scalar_opacity", 9});  // the plain name counts
  const SceneFile file = read(ply(both));
  check_plain(file);
  CHECK(contains(all_notes(file.notes), "scalar_opacity"));
}

// gsplat 1.5.3, export_splats(format="ply_compressed"), of degree 0: an element `sh` without properties.
TEST_CASE("layouts: gsplat's compressed PLY has an empty element of harmonics") {
  CompressedPly compressed;
  // Ranges of one value divide by 0 there, so any fraction may be stored.
  compressed.chunks = {1, 2, 3, 1, 2, 3, 1, 2, 3, 1, 2, 3, 1, 2, 3, 1, 2, 3};
  compressed.vertices = {0x80000000u, 0x20080200u, 0x7fffffffu, 0xff0000ffu};
  const SceneFile file = read(with(compressed.text(), "end_header", "element sh 1\nend_header"));
  REQUIRE(file.scene.size() == 1);
  CHECK(file.scene.means[0] == vec3(1, 2, 3));
  CHECK(file.scene.scales[0].z == doctest::Approx(std::exp(3.0)));
  CHECK(file.scene.opacities[0] == 1);
  CHECK(file.scene.sh_degree == 0);
  CHECK(file.notes.empty());
}

// COLMAP 3.8 points3D.ply and fused.ply, nerfstudio's sparse_pc.ply, INRIA's input.ply, and Luma's scan.
TEST_CASE("layouts: a point cloud is called one") {
  std::vector<PlyValue> points = {{"float", "x", 0},   {"float", "y", 0},     {"float", "z", 0},
                                  {"uchar", "red", 0}, {"uchar", "green", 0}, {"uchar", "blue", 0}};
  const std::string expected = "a file: byte 36: expected Gaussians, found a point cloud with no Gaussians: ";
  CHECK(complaint_about(ply(points)) == expected + "properties x y z red green blue");
  points.insert(points.begin() + 3, {{"float", "nx", 0}, {"float", "ny", 0}, {"float", "nz", 0}});
  CHECK(complaint_about(ply(points)) == expected + "properties x y z nx ny nz red green blue");
  auto half = plain_gaussian();
  remove(half, "rot_3");
  CHECK(contains(complaint_about(ply(half)), "a property 'rot_3'"));
}

// Metashape and RealityCapture keep projected coordinates in double; Open3D 0.19 writes all properties so.
TEST_CASE("layouts: positions that float cannot hold are relative to an origin") {
  for (const std::string format : ply_formats)
    for (const std::string type : {"double", "int", "uint"}) {
      CAPTURE(format);
      CAPTURE(type);
      if (format == "ascii" && type != "double") continue;  // of more digits than the text has
      auto gaussian = plain_gaussian();
      for (PlyValue& value : gaussian)
        if (type == "double") value.type = type;
      const double far = type == "double" ? 5403209.75 : 16777217 * 8 + 4;
      for (const char* axis : {"x", "y"}) property(gaussian, axis) = {type, axis, far};
      const SceneFile file = read(ply(gaussian, {.format = format}));
      CHECK(file.scene.origin + dvec3(file.scene.means[0]) == dvec3(far, far, -3));
      CHECK(glm::length(file.scene.means[0]) < 1);
      const std::string origin = type == "double" ? "5403209.75,5403209.75,-3" : "134217740,134217740,-3";
      REQUIRE(file.notes.size() == 1);
      CHECK(contains(file.notes[0], "relative to the origin " + origin + "."));
    }
  auto near = plain_gaussian();
  for (PlyValue& value : near) value.type = "double";
  property(near, "x").value = 0.1;
  const SceneFile file = read(ply(near));
  CHECK(file.scene.means[0].x == 0.1f);
  CHECK(file.scene.origin == dvec3(0));
  CHECK(file.notes.empty());
}

TEST_CASE("layouts: Gaussians that are left out have no say in the origin and take no others along") {
  auto gaussian = plain_gaussian();
  for (const char* axis : {"x", "y", "z"}) property(gaussian, axis) = {"double", axis, 1e7 + 0.25};
  std::string content = ply(gaussian, {.repeat = 3});
  constexpr std::size_t row = 11 * 4 + 3 * 8;
  const std::size_t last = content.size() - row;
  const double other = 1e7 + 1.75;
  content = with(content, last, other);
  const auto check = [&](const std::string& changed, std::size_t not_finite) {
    const SceneFile file = read(changed);
    CHECK(file.left_out.not_finite == not_finite);
    CHECK(file.left_out.no_rotation == 1 - not_finite);
    REQUIRE(file.scene.size() == 2);
    CHECK(file.scene.origin + dvec3(file.scene.means[0]) == dvec3(1e7 + 0.25));
    CHECK(file.scene.origin.x + double(file.scene.means[1].x) == other);
  };
  for (const double bad : {1e300, -1e39, double(NAN), double(-INFINITY)}) {  // beyond float, or no numbers
    CAPTURE(bad);
    check(with(content, last - row, bad), 1);
  }
  check(std::string(content).replace(last - row, row, row, '\0'), 0);
}

}  // namespace swiftgs::test::layouts_test
