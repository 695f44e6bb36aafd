// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <sstream>

#include "camera_files.hpp"

namespace swiftgs::test::colmap_models_test {

namespace {

struct Model {
  std::int32_t number;
  std::string name;
  std::vector<double> parameters;
};

/// Those that are pinholes where the coefficients are 0; of EUCM one of alpha and beta suffices.
const Model pinholes[] = {{0, "SIMPLE_PINHOLE", {50, 33, 22}},
                          {1, "PINHOLE", {50, 60, 33, 22}},
                          {2, "SIMPLE_RADIAL", {50, 33, 22, 0}},
                          {3, "RADIAL", {50, 33, 22, 0, 0}},
                          {4, "OPENCV", {50, 60, 33, 22, 0, 0, 0, 0}},
                          {6, "FULL_OPENCV", {50, 60, 33, 22, 0, 0, 0, 0, 0, 0, 0, 0}},
                          {7, "FOV", {50, 60, 33, 22, 0}},
                          {12, "SIMPLE_DIVISION", {50, 33, 22, 0}},
                          {13, "DIVISION", {50, 60, 33, 22, 0}},
                          {16, "EUCM", {50, 60, 33, 22, 0, 0}},
                          {16, "EUCM", {50, 60, 33, 22, 0, -1e-5}},
                          {16, "EUCM", {50, 60, 33, 22, 0.6, 0}}};

/// Those that no lens can be, and what of them is named beside the model.
const std::pair<Model, std::string> refused_models[] = {
    {{7, "FOV", {50, 60, 33, 22, -1e-5}}, " with omega = -1e-05"},
    {{12, "SIMPLE_DIVISION", {50, 33, 22, -1e-5}}, " with k = -1e-05"},
    {{13, "DIVISION", {50, 60, 33, 22, -1e-5}}, " with k = -1e-05"},
    {{7, "FOV", {50, 60, 33, 22, 0.9272952}}, " with omega = 0.9272952"},
    {{16, "EUCM", {50, 60, 33, 22, -1e-5, 1}}, " with alpha = -1e-05"},
    {{11, "RAD_TAN_THIN_PRISM_FISHEYE", {50, 60, 33, 22, 0, 0, 0, 0, 1e-5, 0, 0, 0, 0, 0, 0, 0}},
     " with k4 = 1e-05"},
    {{11, "RAD_TAN_THIN_PRISM_FISHEYE", {50, 60, 33, 22, 0, 0, 0, 0, 0, 1e-5, 0, 0, 0, 0, 0, 0}},
     " with k5 = 1e-05"},
    {{11, "RAD_TAN_THIN_PRISM_FISHEYE", {50, 60, 33, 22, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1e-5, 0, 0}},
     " with s1 = 1e-05"},
    {{11, "RAD_TAN_THIN_PRISM_FISHEYE", {50, 60, 33, 22, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1e-5}},
     " with s3 = 1e-05"},
    {{11, "RAD_TAN_THIN_PRISM_FISHEYE", {50, 60, 33, 22, 0, 1e-5, 0, 0, 0, 0, 0, 1e-5, 0, 0, 0, 0}},
     " with radial terms beside tangential or prism ones"}};

/// Those that are fisheye lenses without distortion, with focal lengths of 50 and 50 or 60.
const Model fisheyes[] = {
    {5, "OPENCV_FISHEYE", {50, 60, 33, 22, 0, 0, 0, 0}},
    {11, "RAD_TAN_THIN_PRISM_FISHEYE", {50, 60, 33, 22, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}},
    {14, "SIMPLE_FISHEYE", {50, 33, 22}},
    {15, "FISHEYE", {50, 60, 33, 22}}};

/// A point of the plane before distortion.
Pixel on_plane(bool fisheye, const dvec3& p) {
  const double tangent = std::hypot(p.x, p.y) / p.z;
  const double turned = fisheye ? std::atan(tangent) / tangent : 1;
  return {p.x / p.z * turned, p.y / p.z * turned};
}

/// OpenCV's terms p1 and p2.
Pixel tangential(double p1, double p2, Pixel at) {
  const double squared = at.x * at.x + at.y * at.y;
  return {2 * p1 * at.x * at.y + p2 * (squared + 2 * at.x * at.x),
          p1 * (squared + 2 * at.y * at.y) + 2 * p2 * at.x * at.y};
}

/// 1 + k[0] r^2 + k[1] r^4 + ...
double radial(const std::vector<double>& k, Pixel at) {
  double sum = 1, power = 1;
  for (const double one : k) sum += one * (power *= at.x * at.x + at.y * at.y);
  return sum;
}

/// Points in all four quarters of an image.
const dvec3 seen_points[] = {{0.3, -0.2, 1}, {-0.5, 0.35, 1.25}, {0.7, 0.9, 2}, {-0.25, -0.6, 0.8}};

/// A model with numbers that all differ, and the part of each term of COLMAP's src/colmap/sensor/models.h.
struct Distorted {
  std::int32_t number;
  std::string name;
  LensModel lens;
  std::vector<double> lengths_and_centre, coefficients;
  std::vector<std::size_t> above, below{};  ///< places of radial coefficients in the factor and its divisor
  bool decentres = false;                   ///< by the third and fourth coefficient
  double prism_x = 0, prism_y = 0;

  std::vector<double> parameters() const {
    std::vector<double> all = lengths_and_centre;
    all.insert(all.end(), coefficients.begin(), coefficients.end());
    return all;
  }

  Pixel shown(const Pixel& at) const {
    const auto factor = [&](const std::vector<std::size_t>& places) {
      std::vector<double> radials;
      for (const std::size_t place : places) radials.push_back(coefficients[place]);
      return radial(radials, at);
    };
    const double scale = factor(above) / factor(below), squared = at.x * at.x + at.y * at.y;
    const Pixel aside = decentres ? tangential(coefficients[2], coefficients[3], at) : Pixel{0, 0};
    const std::vector<double>& n = lengths_and_centre;
    return {n[0] * (at.x * scale + aside.x + prism_x * squared) + n[n.size() - 2],
            n[n.size() - 3] * (at.y * scale + aside.y + prism_y * squared) + n[n.size() - 1]};
  }
};

const std::vector<double> one_length = {50, 33, 22}, two_lengths = {50, 60, 33, 22};
constexpr LensModel perspective = LensModel::perspective, fisheye = LensModel::fisheye;
const Distorted distorted[] = {
    {2, "SIMPLE_RADIAL", perspective, one_length, {-0.11}, {0}},
    {3, "RADIAL", perspective, one_length, {-0.11, 0.07}, {0, 1}},
    {4, "OPENCV", perspective, two_lengths, {-0.11, 0.07, 0.013, -0.021}, {0, 1}, {}, true},
    {6,
     "FULL_OPENCV",
     perspective,
     two_lengths,
     {-0.11, 0.07, 0.013, -0.021, 0.017, 0.19, 0.053, -0.029},
     {0, 1, 4},
     {5, 6, 7},
     true},
    {8, "SIMPLE_RADIAL_FISHEYE", fisheye, one_length, {-0.11}, {0}},
    {9, "RADIAL_FISHEYE", fisheye, one_length, {-0.11, 0.07}, {0, 1}},
    {5, "OPENCV_FISHEYE", fisheye, two_lengths, {-0.11, 0.07, 0.023, -0.013}, {0, 1, 2, 3}},
    {10,
     "THIN_PRISM_FISHEYE",
     fisheye,
     two_lengths,
     {-0.11, 0.07, 0.013, -0.021, 0.023, -0.017, 0.031, -0.043},
     {0, 1, 4, 5},
     {},
     true,
     0.031,
     -0.043},
    {11,
     "RAD_TAN_THIN_PRISM_FISHEYE",
     fisheye,
     two_lengths,
     {-0.11, 0.07, 0.023, -0.013, 0, 0, 0, 0, 0, 0, 0, 0},
     {0, 1, 2, 3}}};

std::vector<Camera> of_binary(std::int32_t number, const std::vector<double>& parameters) {
  return parse_binary(cameras_bin({{.model = number, .width = 64, .height = 48, .parameters = parameters}}),
                      images_bin({{}}));
}

std::vector<Camera> of_text(const std::string& name, const std::vector<double>& parameters) {
  std::ostringstream line;
  line.precision(17);
  line << "1 " << name << " 64 48";
  for (const double value : parameters) line << ' ' << value;
  return parse_text(line.str(), "1 1 0 0 0 0 0 0 1 a.jpg\n\n");
}

const std::string expected =
    "expected one of the camera models SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, "
    "OPENCV_FISHEYE, FULL_OPENCV, SIMPLE_RADIAL_FISHEYE, RADIAL_FISHEYE, THIN_PRISM_FISHEYE, "
    "SIMPLE_FISHEYE, FISHEYE, EQUIRECTANGULAR, found ";

}  // namespace

TEST_CASE("colmap models: a model whose coefficients are 0 is a pinhole") {
  for (const Model& model : pinholes) {
    CAPTURE(model.name);
    for (const auto& cameras :
         {of_binary(model.number, model.parameters), of_text(model.name, model.parameters)}) {
      REQUIRE(cameras.size() == 1);
      CHECK(cameras[0].lens.is_pinhole());
      CHECK(intrinsics(cameras[0]) == Intrinsics{64, 48, 50, std::max(50.0, model.parameters[1]), 33, 22});
    }
  }
}

TEST_CASE("colmap models: every coefficient moves points as COLMAP's model does") {
  for (const Distorted& model : distorted) {
    CAPTURE(model.name);
    for (const auto& cameras :
         {of_binary(model.number, model.parameters()), of_text(model.name, model.parameters())}) {
      REQUIRE(cameras.size() == 1);
      CHECK(cameras[0].lens.model == model.lens);
      CHECK(cameras[0].lens.is_distorted());
      for (const dvec3& p : seen_points)
        check_pixel(cameras[0], p, model.shown(on_plane(model.lens == fisheye, p)));
    }
  }
}

TEST_CASE("colmap models: a fisheye lens without distortion is no pinhole") {
  for (const Model& model : fisheyes) {
    CAPTURE(model.name);
    for (const auto& cameras :
         {of_binary(model.number, model.parameters), of_text(model.name, model.parameters)}) {
      CHECK(cameras.at(0).lens == Lens{fisheye, {}});
      CHECK(intrinsics(cameras[0]) == Intrinsics{64, 48, 50, std::max(50.0, model.parameters[1]), 33, 22});
      // 45 degrees to the right.
      check_pixel(cameras[0], {1, 0, 1}, {33 + 50 * std::atan(1.0), 22});
    }
  }
}

TEST_CASE("colmap models: a field of view whose tangents are lengths is a fisheye lens") {
  const double half = std::atan(0.5);
  for (const double omega : {2 * half, -2 * half}) {
    const std::vector<double> parameters = {50, 60, 33, 22, omega};
    for (const auto& cameras : {of_binary(7, parameters), of_text("FOV", parameters)}) {
      CHECK(cameras.at(0).lens == Lens{fisheye, {}});
      for (const dvec3& p : seen_points) {
        // FOVCameraModel::Distortion of COLMAP's src/colmap/sensor/models.h.
        const double radius = std::hypot(p.x, p.y) / p.z;
        const double factor = std::atan(radius * 2 * std::tan(omega / 2)) / (radius * omega);
        check_pixel(cameras[0], p, {50 * factor * p.x / p.z + 33, 60 * factor * p.y / p.z + 22});
      }
    }
  }
}

// RadTanThinPrismFisheyeModel there: p0 goes with u, and s0, s2 with the square of the radius.
TEST_CASE("colmap models: tangential and prism terms of 16 parameters alone move points as COLMAP's do") {
  const std::vector<double> parameters = {50, 60, 33,     22,    0,     0, 0,      0,
                                          0,  0,  -0.021, 0.013, 0.031, 0, -0.043, 0};
  REQUIRE(parameters.size() == 16);
  for (const auto& cameras : {of_binary(11, parameters), of_text("RAD_TAN_THIN_PRISM_FISHEYE", parameters)})
    for (const dvec3& p : seen_points) {
      const auto [x, y] = on_plane(true, p);
      const double squared = x * x + y * y;
      const double u = x + 2 * 0.013 * x * y - 0.021 * (squared + 2 * x * x) + 0.031 * squared;
      const double v = y - 2 * 0.021 * x * y + 0.013 * (squared + 2 * y * y) - 0.043 * squared;
      check_pixel(cameras.at(0), p, {50 * u + 33, 60 * v + 22});
    }
}

// Called SPHERICAL in forks, before COLMAP 4.1.
TEST_CASE("colmap models: an equirectangular image has a whole sphere of as many pixels as the file says") {
  for (const auto& [width, height] : {std::pair{64.0, 48.0}, {72.5, 32.0}})
    for (const auto& cameras : {of_binary(17, {width, height}), of_text("EQUIRECTANGULAR", {width, height}),
                                of_text("SPHERICAL", {width, height})}) {
      CHECK(cameras.at(0).lens == Lens{LensModel::equirectangular, {}});
      CHECK(cameras[0].width == 64);
      CHECK(cameras[0].height == 48);
      for (const dvec3& p : {dvec3(0.3, -0.2, 1), dvec3(-0.5, 0.35, -1.25), dvec3(0.7, -0.9, -2)}) {
        const double pi = std::acos(-1.0);
        check_pixel(cameras[0], p,
                    {(std::atan2(p.x, p.z) / (2 * pi) + 0.5) * width,
                     (std::atan2(p.y, std::hypot(p.x, p.z)) / pi + 0.5) * height});
      }
    }
  for (const double bad : {0.0, -64.0, double(NAN)})
    CHECK(contains(complaint([&] {
                     of_binary(17, {bad, 48});
                   }),
                   "expected a camera that can be rendered with (camera: expected focal lengths"));
}

TEST_CASE("colmap models: models that no lens can be are refused by name") {
  for (const auto& [model, found] : refused_models) {
    CAPTURE(model.name);
    const Model& m = model;
    const std::string message = expected + m.name + found;
    CHECK(complaint([&] { of_binary(m.number, m.parameters); }) == "cameras.bin: byte 8: " + message);
    CHECK(complaint([&] { of_text(m.name, m.parameters); }) == "cameras.txt: byte 0: " + message);
  }
  for (const std::int32_t number : {18, -1})
    CHECK(contains(complaint([&] {
                     of_binary(number, {1, 2, 3, 4});
                   }),
                   expected + "number " + std::to_string(number)));
  CHECK(contains(complaint([&] { of_text("METASHAPE", {1, 2, 3, 4}); }), expected + "METASHAPE"));
}

TEST_CASE("colmap models: coefficients that no image can be drawn with are refused") {
  for (const double bad : {double(NAN), double(INFINITY), 1e7}) {
    CAPTURE(bad);
    CHECK(contains(complaint([&] {
                     of_binary(4, {50, 60, 33, 22, 0, 0, 0, bad});
                   }),
                   "expected distortion coefficients of at most 1e6"));
  }
}

TEST_CASE("colmap models: a camera that no image uses may be of any model") {
  const std::string images = images_bin({{.camera_id = 2}});
  const ColmapCamera used{.id = 2};
  const auto beside = [&](const ColmapCamera& unused) {
    return parse_binary(cameras_bin({unused, used}), images).at(0).fx;
  };
  CHECK(beside({.model = 7, .parameters = {1, 1, 1, 1, 0.1}}) == 500);
  CHECK(beside({.model = 17, .parameters = {0, 0}}) == 500);
  CHECK(beside({.width = 0, .parameters = {-1, 0, 0, 0}}) == 500);

  const std::string used_line = "2 PINHOLE 640 480 500 510 321 239\n", image = "1 1 0 0 0 0 0 0 2 a.jpg\n\n";
  for (const std::string unused :
       {"1 FOV 640 480 1 1 1 1 0.1\n", "1 LATER_MODEL 640 480 1\n", "1 PINHOLE 0 0 1 1\n", "1\n"}) {
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

// hierarchical-3d-gaussians, 2024, scripts for MatrixCity: "one line of data per image".
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

// Editors of Windows and PowerShell write the mark, classic Mac OS the line ends.
TEST_CASE("colmap models: a byte order mark and any line ends are no part of the text") {
  const std::string cameras = "# Cameras\n1 PINHOLE 640 480 500 510 321 239\n",
                    images = "# Images\n1 1 0 0 0 0 0 3 1 a b.jpg\n1 2 -1\n2 1 0 0 0 0 0 3 1 b.jpg\n\n";
  for (const std::string mark : {"", "\xef\xbb\xbf"})
    for (const std::string end : {"\n", "\r\n", "\r"}) {
      const auto as_written = [&](std::string text) {
        for (std::size_t at = 0; (at = text.find('\n', at)) != text.npos; at += end.size())
          text.replace(at, 1, end);
        return mark + text;
      };
      const auto found = parse_text(as_written(cameras), as_written(images));
      REQUIRE(found.size() == 2);
      CHECK(found[0].name == "a b.jpg");
      CHECK(found[1].fy == 510);
      const std::string place =
          "images.txt: byte " + std::to_string(mark.size()) + ": expected a number for ";
      CHECK(contains(complaint([&] { parse_text(cameras, mark + "x"); }), place + "an image id"));
    }
}

TEST_CASE("colmap models: texts in other encodings are refused with what they are") {
  const std::string line = "1 PINHOLE", image = "1 1 0 0 0 0 0 3 1 a.jpg\n";
  std::string little, big;
  for (const char c : line) little += {c, '\0'}, big += {'\0', c};
  for (const std::string& text : {"\xff\xfe" + little, "\xfe\xff" + big, little, big}) {
    const std::string found = "expected a text in UTF-8, found one in UTF-16";
    CHECK(complaint([&] { parse_text(text, image); }) == "cameras.txt: byte 0: " + found);
    CHECK(complaint([&] { parse_text("1 PINHOLE 640 480 500 510 321 239", text); }) ==
          "images.txt: byte 0: " + found);
  }
}

}  // namespace swiftgs::test::colmap_models_test
