// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdint>
#include <sstream>
#include <string>
#include <vector>

#include <swiftgs/io/cameras.hpp>

#include "colmap_files.hpp"
#include "lens_pixels.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// A model with `rest` coefficients.
struct Model {
  std::int32_t number;
  std::string name;
  bool two_lengths;
  int rest;
  std::vector<std::string> coefficients{};  ///< their names, but for those that do nothing

  /// fx 50, and fy 60 where the model has two focal lengths, centre (33, 22), and one coefficient that is not
  /// 0.
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
                          {2, "SIMPLE_RADIAL", false, 1},
                          {3, "RADIAL", false, 2},
                          {4, "OPENCV", true, 4},
                          {6, "FULL_OPENCV", true, 8},
                          {7, "FOV", true, 1},
                          {12, "SIMPLE_DIVISION", false, 1},
                          {13, "DIVISION", true, 1},
                          {16, "EUCM", true, 2}};

/// Those that are nothing else.
const Model pinholes_alone[] = {{7, "FOV", true, 1, {"omega"}},
                                {12, "SIMPLE_DIVISION", false, 1, {"k"}},
                                {13, "DIVISION", true, 1, {"k"}},
                                {16, "EUCM", true, 2, {"alpha"}}};

/// Those that are never read.
const Model others[] = {
    {14, "SIMPLE_FISHEYE", false, 0}, {15, "FISHEYE", true, 0}, {11, "RAD_TAN_THIN_PRISM_FISHEYE", true, 12}};

/// A model with numbers that all differ, and where COLMAP's src/colmap/sensor/models.h shows a point with it.
struct Distorted {
  std::int32_t number;
  std::string name;
  LensModel lens;
  std::vector<double> parameters;
  Pixel (*shown)(const std::vector<double>& numbers, Pixel plane);
};

const Distorted distorted[] = {
    {2,
     "SIMPLE_RADIAL",
     LensModel::perspective,
     {50, 33, 22, -0.11},
     [](const std::vector<double>& n, Pixel at) {
       const double scale = radial({n[3]}, at);
       return Pixel{n[0] * at.x * scale + n[1], n[0] * at.y * scale + n[2]};
     }},
    {3,
     "RADIAL",
     LensModel::perspective,
     {50, 33, 22, -0.11, 0.07},
     [](const std::vector<double>& n, Pixel at) {
       const double scale = radial({n[3], n[4]}, at);
       return Pixel{n[0] * at.x * scale + n[1], n[0] * at.y * scale + n[2]};
     }},
    {4,
     "OPENCV",
     LensModel::perspective,
     {50, 60, 33, 22, -0.11, 0.07, 0.013, -0.021},
     [](const std::vector<double>& n, Pixel at) {
       const double scale = radial({n[4], n[5]}, at);
       const Pixel aside = tangential(n[6], n[7], at);
       return Pixel{n[0] * (at.x * scale + aside.x) + n[2], n[1] * (at.y * scale + aside.y) + n[3]};
     }},
    {6,
     "FULL_OPENCV",
     LensModel::perspective,
     {50, 60, 33, 22, -0.11, 0.07, 0.013, -0.021, 0.017, 0.19, 0.053, -0.029},
     [](const std::vector<double>& n, Pixel at) {
       const double scale = radial({n[4], n[5], n[8]}, at) / radial({n[9], n[10], n[11]}, at);
       const Pixel aside = tangential(n[6], n[7], at);
       return Pixel{n[0] * (at.x * scale + aside.x) + n[2], n[1] * (at.y * scale + aside.y) + n[3]};
     }},
    {8,
     "SIMPLE_RADIAL_FISHEYE",
     LensModel::fisheye,
     {50, 33, 22, -0.11},
     [](const std::vector<double>& n, Pixel at) {
       const double scale = radial({n[3]}, at);
       return Pixel{n[0] * at.x * scale + n[1], n[0] * at.y * scale + n[2]};
     }},
    {9,
     "RADIAL_FISHEYE",
     LensModel::fisheye,
     {50, 33, 22, -0.11, 0.07},
     [](const std::vector<double>& n, Pixel at) {
       const double scale = radial({n[3], n[4]}, at);
       return Pixel{n[0] * at.x * scale + n[1], n[0] * at.y * scale + n[2]};
     }},
    {5,
     "OPENCV_FISHEYE",
     LensModel::fisheye,
     {50, 60, 33, 22, -0.11, 0.07, 0.023, -0.013},
     [](const std::vector<double>& n, Pixel at) {
       const double scale = radial({n[4], n[5], n[6], n[7]}, at);
       return Pixel{n[0] * at.x * scale + n[2], n[1] * at.y * scale + n[3]};
     }},
    {10,
     "THIN_PRISM_FISHEYE",
     LensModel::fisheye,
     {50, 60, 33, 22, -0.11, 0.07, 0.013, -0.021, 0.023, -0.017, 0.031, -0.043},
     [](const std::vector<double>& n, Pixel at) {
       const double scale = radial({n[4], n[5], n[8], n[9]}, at), squared = at.x * at.x + at.y * at.y;
       const Pixel aside = tangential(n[6], n[7], at);
       return Pixel{n[0] * (at.x * scale + aside.x + n[10] * squared) + n[2],
                    n[1] * (at.y * scale + aside.y + n[11] * squared) + n[3]};
     }}};

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
    "expected one of the camera models SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, FULL_OPENCV, "
    "OPENCV_FISHEYE, SIMPLE_RADIAL_FISHEYE, RADIAL_FISHEYE, THIN_PRISM_FISHEYE, found ";

void check_refused(const Model& model, const std::vector<double>& parameters, const std::string& found) {
  CAPTURE(model.name);
  CHECK(complaint([&] { of_binary(model.number, parameters); }) ==
        "cameras.bin: byte 8: " + expected + found);
  CHECK(complaint([&] { of_text(model.name, parameters); }) == "cameras.txt: byte 0: " + expected + found);
}

}  // namespace

TEST_CASE("colmap models: a model whose coefficients are 0 is a pinhole") {
  for (const Model& model : pinholes) {
    CAPTURE(model.name);
    const std::vector<double> parameters = model.parameters(0);
    for (const auto& cameras : {of_binary(model.number, parameters), of_text(model.name, parameters)}) {
      REQUIRE(cameras.size() == 1);
      CHECK(cameras[0].lens.is_pinhole());
      CHECK(cameras[0].fx == 50);
      CHECK(cameras[0].fy == (model.two_lengths ? 60 : 50));
      CHECK(cameras[0].cx == 33);
      CHECK(cameras[0].cy == 22);
      CHECK(cameras[0].width == 64);
      CHECK(cameras[0].height == 48);
    }
  }
}

TEST_CASE("colmap models: every coefficient moves points as COLMAP's model does") {
  for (const Distorted& model : distorted) {
    CAPTURE(model.name);
    for (const auto& cameras :
         {of_binary(model.number, model.parameters), of_text(model.name, model.parameters)}) {
      REQUIRE(cameras.size() == 1);
      CHECK(cameras[0].lens.model == model.lens);
      CHECK(cameras[0].lens.is_distorted());
      for (const dvec3& p : seen_points)
        check_pixel(cameras[0], p,
                    model.shown(model.parameters, on_plane(model.lens == LensModel::fisheye, p)));
    }
  }
}

TEST_CASE("colmap models: a fisheye lens without distortion is no pinhole") {
  const std::vector<double> parameters = {50, 60, 33, 22, 0, 0, 0, 0};
  for (const auto& cameras : {of_binary(5, parameters), of_text("OPENCV_FISHEYE", parameters)}) {
    CHECK(cameras.at(0).lens == Lens{LensModel::fisheye, {}});
    // 45 degrees to the right.
    check_pixel(cameras[0], {1, 0, 1}, {33 + 50 * std::atan(1.0), 22});
  }
}

TEST_CASE("colmap models: models that no lens can be are refused by name") {
  for (const Model& model : pinholes_alone)
    for (int at = 0; at < model.rest; ++at) {
      const std::vector<double> parameters = model.parameters(-1e-5, at);
      // EUCM's beta does nothing where alpha is 0.
      if (at >= int(model.coefficients.size()))
        CHECK(of_binary(model.number, parameters).at(0).lens.is_pinhole());
      else
        check_refused(model, parameters,
                      model.name + " with " + model.coefficients[std::size_t(at)] + " = -1e-05");
    }
  for (const Model& model : others) check_refused(model, model.parameters(0), model.name);
  check_refused({17, "EQUIRECTANGULAR", false, 0}, {64, 48}, "EQUIRECTANGULAR");
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
  CHECK(beside({.model = 17, .parameters = {640, 480}}) == 500);
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
