// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdint>
#include <string>
#include <system_error>
#include <vector>

#include <swiftgs/io/cameras.hpp>

#include "colmap_files.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

const std::string cameras_txt =
    "# Camera list\n1 PINHOLE 640 480 500 510 321 239\r\n\n2 SIMPLE_PINHOLE 64 48 50 32 24\n";
const std::string images_txt =
    "# Image list\n#   POINTS2D[]\n"
    "1 2 0 0 2 1 2 3 1 z.jpg\n10 20 -1 30 40 7\n"
    "2 1 0 0 0 0 0 0 2 a name.jpg\n\n"
    "3 1 0 0 0 0 0 1 1 b.jpg\n";

void check_first(const Camera& c) {
  CHECK(c.width == 640);
  CHECK(c.height == 480);
  CHECK(c.fx == 500);
  CHECK(c.fy == 510);
  CHECK(c.cx == 321);
  CHECK(c.cy == 239);
  CHECK(c.translation == dvec3(1, 2, 3));
  const dvec3 x = c.rotation * dvec3(1, 0, 0);
  CHECK(x.x == doctest::Approx(0));
  CHECK(x.y == doctest::Approx(1));
  CHECK_NOTHROW(validate(c));
}

}  // namespace

TEST_CASE("colmap: binary cameras are found by id and quaternions need not be unit") {
  const std::string cameras =
      cameras_bin({{.id = 9, .model = 0, .width = 64, .height = 48, .parameters = {50, 32, 24}}, {}});
  const std::string images =
      images_bin({{}, {.name = "b.jpg", .camera_id = 9, .points = 0, .stored_points = 0}});
  const auto result = parse_binary(cameras, images);
  REQUIRE(result.size() == 2);
  check_first(result[0]);
  CHECK(result[0].name == "a.jpg");
  CHECK(result[1].fx == 50);
  CHECK(result[1].fy == 50);
  CHECK(result[1].cx == 32);
  CHECK(result[1].cy == 24);
}

TEST_CASE("colmap: text has two lines an image of which the second may be empty or missing at the end") {
  const auto result = parse_text(cameras_txt, images_txt);
  REQUIRE(result.size() == 3);
  check_first(result[0]);
  CHECK(result[1].name == "a name.jpg");
  CHECK(result[1].fy == 50);
  CHECK(result[2].name == "b.jpg");
}

TEST_CASE("colmap: a general rotation agrees between quaternion and matrix") {
  ColmapImage image;
  const double pose[7] = {0.5, -0.3, 0.7, 0.1, 0, 0, 0};
  std::copy(pose, pose + 7, image.pose);
  const Camera camera = parse_binary(cameras_bin({{}}), images_bin({image}))[0];
  // q v q* with the vector part of q scaled to a unit quaternion.
  const double length = std::sqrt(0.84), w = 0.5 / length;
  const dvec3 u(-0.3 / length, 0.7 / length, 0.1 / length), v(0.2, -1.5, 0.8);
  const auto cross = [](dvec3 a, dvec3 b) {
    return dvec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
  };
  const dvec3 expected = v + 2 * w * cross(u, v) + 2.0 * cross(u, cross(u, v)), found = camera.rotation * v;
  for (int axis = 0; axis < 3; ++axis) CHECK(found[axis] == doctest::Approx(expected[axis]).epsilon(1e-12));
}

TEST_CASE("colmap: a model is found in its folder or below it and binary wins") {
  const TemporaryFolder folder;
  folder.write("text/cameras.txt", cameras_txt);
  folder.write("text/images.txt", images_txt);
  const auto text = load_cameras(folder / "text");
  REQUIRE(text.size() == 3);
  CHECK(text[0].name == "a name.jpg");
  CHECK(text[2].name == "z.jpg");

  folder.write("both/sparse/0/cameras.txt", cameras_txt);
  folder.write("both/sparse/0/images.txt", images_txt);
  CHECK(load_cameras(folder / "both").size() == 3);
  folder.write("both/sparse/0/cameras.bin", cameras_bin({{}}));
  CHECK(load_cameras(folder / "both").size() == 3);
  folder.write("both/sparse/0/images.bin", images_bin({{}}));
  CHECK(load_cameras(folder / "both").size() == 1);
  CHECK(load_cameras(folder / "both/sparse/0").size() == 1);
  CHECK(load_cameras(folder / "both/sparse").size() == 1);
  CHECK_THROWS_AS(load_cameras(folder.path()), std::invalid_argument);
}

TEST_CASE("colmap: a binary file that ends early is refused wherever it ends") {
  const std::string cameras = cameras_bin({{}, {.id = 2}}), images = images_bin({{}, {.name = "b"}});
  check_every_truncation(cameras, [&](const std::string& part) { parse_binary(part, images); });
  check_every_truncation(images, [&](const std::string& part) { parse_binary(cameras, part); });
}

TEST_CASE("colmap: a text file that ends early never crashes") {
  for (std::size_t length = 0; length < images_txt.size(); ++length)
    CHECK_NOTHROW(complaint([&] { parse_text(cameras_txt, images_txt.substr(0, length)); }));
  // The last number may be shorter than it was.
  for (std::size_t length = 0; length + 2 < cameras_txt.size(); ++length)
    CHECK(complaint([&] { parse_text(cameras_txt.substr(0, length), images_txt); }) != "");
}

TEST_CASE("colmap: counts that the file cannot hold are refused before memory is taken") {
  const auto with_count = [](std::string file, std::uint64_t count) {
    std::string raw;
    append(raw, count);
    return file.replace(0, 8, raw);
  };
  const std::string cameras = cameras_bin({{}}), images = images_bin({{}});
  for (const std::uint64_t count : {std::uint64_t(2), std::uint64_t(1) << 40, ~std::uint64_t(0)}) {
    CHECK(complaint([&] { parse_binary(with_count(cameras, count), images); }) != "");
    CHECK(complaint([&] { parse_binary(cameras, with_count(images, count)); }) != "");
  }
  CHECK(contains(complaint([&] { parse_binary(cameras, with_count(images, 0)); }), "end of the file"));
  for (const std::uint64_t points : {std::uint64_t(3), ~std::uint64_t(0) / 24 + 1, ~std::uint64_t(0)})
    CHECK(contains(complaint([&] { parse_binary(cameras, images_bin({{.points = points}})); }), "points"));
}

TEST_CASE("colmap: values that make no camera are refused") {
  const auto camera = [](ColmapCamera c) {
    return complaint([&] { parse_binary(cameras_bin({c}), images_bin({{}})); });
  };
  CHECK(contains(camera({.width = 0}), "a width and a height"));
  CHECK(contains(camera({.height = ~std::uint64_t(0)}), "a width and a height"));
  CHECK(contains(camera({.parameters = {-1, 1, 1, 1}}), "focal lengths of 1e-6 to 1e12 pixels"));
  CHECK(contains(camera({.parameters = {1, 1, NAN, 1}}), "principal point"));
  CHECK(contains(camera({.id = 3}), "images.bin: byte 8: expected the id of a known camera, found 1"));
  CHECK(contains(complaint([] { parse_binary(cameras_bin({{}, {}}), images_bin({{}})); }), "once"));
  for (const double bad : {0.0, double(NAN), double(INFINITY)}) {
    ColmapImage image;
    image.pose[0] = image.pose[3] = bad;
    CHECK(contains(complaint([&] { parse_binary(cameras_bin({{}}), images_bin({image})); }), "quaternion"));
  }
  ColmapImage image;
  image.pose[5] = NAN;
  CHECK(contains(complaint([&] { parse_binary(cameras_bin({{}}), images_bin({image})); }), "translation"));
}

TEST_CASE("colmap: text that is no camera and no image is placed") {
  const auto cameras = [](const std::string& line) {
    return complaint([&] { parse_text("# one\n" + line + "\n", images_txt); });
  };
  CHECK(contains(cameras("x PINHOLE 640 480 1 2 3 4"),
                 "cameras.txt: byte 6: expected a number for a camera id"));
  CHECK(contains(cameras("1 PINHOLE 640 480 1 2 3"), "camera parameter"));
  CHECK(contains(cameras("1 PINHOLE 640 480 1 2 3 4 5"), "found more"));
  CHECK(contains(cameras("1 PINHOLE 640.5 480 1 2 3 4"), "a width"));
  CHECK(contains(cameras("1 PINHOLE 640 480 1 2 3 4\n1 PINHOLE 640 480 1 2 3 4"), "once"));
  const auto images = [](const std::string& line) {
    return complaint([&] { parse_text(cameras_txt, line + "\n\n"); });
  };
  CHECK(contains(images("1 1 0 0 0 0 0 0 5 a.jpg"), "known camera, found 5"));
  CHECK(contains(images("1 1 0 0 0 0 0 0 1"), "image name"));
  CHECK(contains(images("1 1 0 0 0 0 0 nothing 1 a"), "a pose"));
  CHECK(contains(images("1 0 0 0 0 0 0 0 1 a"), "quaternion"));
}

namespace {

/// A model with fx 50, and fy 60 where it has two focal lengths, centre (33, 22), and `rest` coefficients.
struct Model {
  std::int32_t number;
  std::string name;
  bool two_lengths;
  int rest;
  std::vector<std::string> coefficients{};  ///< their names, but for those that do nothing

  std::vector<double> parameters(double coefficient, int at = 0) const {
    std::vector<double> values = {50, 33, 22};
    if (two_lengths) values.insert(values.begin() + 1, 60);
    values.resize(values.size() + std::size_t(rest), 0.0);
    if (rest > 0) values[values.size() - std::size_t(rest - at)] = coefficient;
    return values;
  }
};

/// Those that are pinholes where the coefficients are 0.
const Model pinholes[] = {{0, "SIMPLE_PINHOLE", false, 0},
                          {1, "PINHOLE", true, 0},
                          {2, "SIMPLE_RADIAL", false, 1, {"k"}},
                          {3, "RADIAL", false, 2, {"k1", "k2"}},
                          {4, "OPENCV", true, 4, {"k1", "k2", "p1", "p2"}},
                          {6, "FULL_OPENCV", true, 8, {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"}},
                          {7, "FOV", true, 1, {"omega"}},
                          {12, "SIMPLE_DIVISION", false, 1, {"k"}},
                          {13, "DIVISION", true, 1, {"k"}},
                          {16, "EUCM", true, 2, {"alpha"}}};

/// Those that never are.
const Model others[] = {{5, "OPENCV_FISHEYE", true, 4},
                        {8, "SIMPLE_RADIAL_FISHEYE", false, 1},
                        {9, "RADIAL_FISHEYE", false, 2},
                        {10, "THIN_PRISM_FISHEYE", true, 8},
                        {14, "SIMPLE_FISHEYE", false, 0},
                        {15, "FISHEYE", true, 0},
                        {11, "RAD_TAN_THIN_PRISM_FISHEYE", true, 12}};

std::vector<Camera> of_binary(const Model& model, const std::vector<double>& parameters) {
  return parse_binary(
      cameras_bin({{.model = model.number, .width = 64, .height = 48, .parameters = parameters}}),
      images_bin({{}}));
}

std::vector<Camera> of_text(const Model& model, const std::vector<double>& parameters) {
  std::string line = "1 ";
  line.append(model.name).append(" 64 48");
  for (const double value : parameters) line.append(" ").append(std::to_string(value));
  return parse_text(line, "1 1 0 0 0 0 0 0 1 a.jpg\n\n");
}

}  // namespace

TEST_CASE("colmap models: a model whose coefficients are 0 is a pinhole") {
  for (const Model& model : pinholes) {
    CAPTURE(model.name);
    for (const auto& cameras : {of_binary(model, model.parameters(0)), of_text(model, model.parameters(0))}) {
      REQUIRE(cameras.size() == 1);
      CHECK(cameras[0].fx == 50);
      CHECK(cameras[0].fy == (model.two_lengths ? 60 : 50));
      CHECK(cameras[0].cx == 33);
      CHECK(cameras[0].cy == 22);
      CHECK(cameras[0].width == 64);
      CHECK(cameras[0].height == 48);
    }
  }
}

TEST_CASE("colmap models: a coefficient that is not 0 is refused wherever it is") {
  const std::string expected =
      "expected a pinhole of undistorted images (PINHOLE, SIMPLE_PINHOLE, or a model whose coefficients are "
      "all 0), found ";
  for (const Model& model : pinholes)
    for (int at = 0; at < model.rest; ++at) {
      CAPTURE(model.name);
      CAPTURE(at);
      const std::vector<double> parameters = model.parameters(-1e-5, at);
      // EUCM's beta does nothing where alpha is 0.
      const bool harmless = at >= int(model.coefficients.size());
      const std::string in_binary = complaint([&] { of_binary(model, parameters); });
      const std::string in_text = complaint([&] { of_text(model, parameters); });
      CHECK(in_binary.empty() == harmless);
      CHECK(in_text.empty() == harmless);
      if (harmless) continue;
      const std::string found =
          expected + model.name + " with " + model.coefficients[std::size_t(at)] + " = -1e-05";
      CHECK(in_binary == "cameras.bin: byte 8: " + found);
      CHECK(in_text == "cameras.txt: byte 0: " + found);
    }
  for (const Model& model : others) {
    CAPTURE(model.name);
    CHECK(complaint([&] { of_binary(model, model.parameters(0)); }) ==
          "cameras.bin: byte 8: " + expected + model.name);
    CHECK(complaint([&] { of_text(model, model.parameters(0)); }) ==
          "cameras.txt: byte 0: " + expected + model.name);
  }
  CHECK(contains(complaint([&] {
                   of_binary({17, "EQUIRECTANGULAR", false, 0}, {64, 48});
                 }),
                 expected + "EQUIRECTANGULAR"));
  for (const std::int32_t number : {18, -1})
    CHECK(contains(complaint([&] {
                     of_binary({number, "", true, 0}, {1, 2, 3, 4});
                   }),
                   expected + "number " + std::to_string(number)));
  CHECK(contains(complaint([&] {
                   of_text({0, "METASHAPE", true, 0}, {1, 2, 3, 4});
                 }),
                 expected + "METASHAPE"));
}

TEST_CASE("colmap models: a camera that no image uses may be of any model") {
  const std::string images = images_bin({{.camera_id = 2}});
  const ColmapCamera used{.id = 2};
  const auto beside = [&](const ColmapCamera& unused) {
    return parse_binary(cameras_bin({unused, used}), images).at(0).fx;
  };
  CHECK(beside({.model = 4, .parameters = {1, 1, 1, 1, 0.1, 0, 0, 0}}) == 500);
  CHECK(beside({.model = 17, .parameters = {640, 480}}) == 500);
  CHECK(beside({.width = 0, .parameters = {-1, 0, 0, 0}}) == 500);

  const std::string used_line = "2 PINHOLE 640 480 500 510 321 239\n", image = "1 1 0 0 0 0 0 0 2 a.jpg\n\n";
  for (const std::string unused :
       {"1 OPENCV 640 480 1 1 1 1 0.1 0 0 0\n", "1 LATER_MODEL 640 480 1\n", "1 PINHOLE 0 0 1 1\n", "1\n"}) {
    CAPTURE(unused);
    CHECK(parse_text(unused + used_line, image).at(0).fx == 500);
    const std::string both = image + "2 1 0 0 0 0 0 0 1 b.jpg\n\n";
    CHECK(contains(complaint([&] { parse_text(unused + used_line, both); }), "cameras.txt: byte 0: "));
  }
}

TEST_CASE("colmap models: a last line needs no line break") {
  const std::string cameras = "1 PINHOLE 640 480 500 510 321 239", image = "1 1 0 0 0 0 0 3 1 a.jpg";
  for (const std::string end : {"", "\n", "\r\n", "\n\n", "\n1 2 -1", "\n1 2 -1 3.5 4.25 17"}) {
    CAPTURE(end);
    const auto found = parse_text(cameras, image + end);
    REQUIRE(found.size() == 1);
    CHECK(found[0].name == "a.jpg");
    CHECK(found[0].cy == 239);
    CHECK(found[0].translation.z == 3);
  }
}

TEST_CASE("colmap models: an image without a line of points is not skipped") {
  const std::string cameras = "1 PINHOLE 640 480 500 510 321 239\n";
  const auto refused = [&](const std::string& images) {
    return complaint([&] { parse_text(cameras, images); });
  };
  const std::string image = "1 1 0 0 0 0 0 0 1 im1.png\n";
  const std::string place = "images.txt: byte " + std::to_string(image.size()) +
                            ": expected the 2D points of the image of line 1 in line 2, X Y POINT3D_ID each, "
                            "or an empty line, found ";
  CHECK(refused(image + "2 1 0 0 0 0 0 0 1 im2.png\n") == place + "im2.png");
  CHECK(refused(image + "2 1 0 0 0 0 0 0 1 0002\n") == place + "10 numbers");
  CHECK(refused(image + "1.5 2.5 -1 3.5\n") == place + "4 numbers");
  CHECK(refused(image + "# images\n") == place + "#");
  CHECK(contains(refused("# head\n" + image + "\n" + image + image),
                 "of the image of line 4 in line 5, X Y POINT3D_ID each"));
  CHECK(parse_text(cameras, image + "1.5 2.5e1 -1 nan inf 18446744073709551615\n" + image).size() == 2);
}
