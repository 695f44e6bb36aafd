// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/io/image.hpp>
#include <swiftgs/io/scene_file.hpp>

#include "cli/command.hpp"
#include "io/ply_text.hpp"

using namespace swiftgs::test;
using swiftgs::Image;
using swiftgs::load_scene;
using swiftgs::read_image;
using swiftgs::vec3;

namespace {

/// A red Gaussian at (-1, -0.5, 2), a few pixels wide in the photograph.
std::vector<PlyValue> red_gaussian() {
  std::vector<PlyValue> gaussian = plain_gaussian();
  property(gaussian, "x").value = -1, property(gaussian, "y").value = -0.5, property(gaussian, "z").value = 2;
  property(gaussian, "f_dc_0").value = 1.77, property(gaussian, "f_dc_1").value = -1.77;
  property(gaussian, "f_dc_2").value = -1.77, property(gaussian, "opacity").value = 6;
  for (const char* scale : {"scale_0", "scale_1", "scale_2"}) property(gaussian, scale).value = -2.5;
  return gaussian;
}

/// As Apple's ml-sharp 1.5.0 writes it, with a focal length of 20 and 48x32 pixels.
std::string photograph() {
  PlyParts parts;
  const auto add = [&](const char* type, const std::string& name, const std::vector<double>& values) {
    parts.after +=
        "element " + name + " " + std::to_string(values.size()) + "\nproperty " + type + " " + name + "\n";
    for (const double value : values) append_value(parts.after_rows, type, value);
  };
  add("float", "extrinsic", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
  add("float", "intrinsic", {20, 0, 24, 0, 20, 16, 0, 0, 1});
  add("uint", "image_size", {48, 32});
  return ply(red_gaussian(), parts);
}

float red_at(const Image& image, int column, int row) {
  return image.pixels[std::size_t(image.channels) * std::size_t(row * image.width + column)];
}

}  // namespace

TEST_CASE("cli layouts: a photograph's scene is drawn from its own camera") {
  const TemporaryFolder place;
  place.write("photo.ply", photograph());
  const Outcome outcome = swiftgs::test::swiftgs(place, "render photo.ply --format pfm");
  CHECK(outcome.code == 0);
  CHECK(outcome.err == "swiftgs: photo.ply: The file holds the camera of its photograph, of 48x32 pixels.\n");
  const Image image = read_image(place / "renders/view.pfm");
  CHECK(image.width == 48);
  CHECK(image.height == 32);
  CHECK(red_at(image, 14, 11) > 0.6f);  // 24 - 20 / 2, 16 - 10 / 2
  CHECK(red_at(image, 34, 21) < 0.01f);
  CHECK(swiftgs::test::swiftgs(place, "render photo.ply --format pfm --scale 2").code == 0);
  CHECK(read_image(place / "renders/view.pfm").width == 96);
}

TEST_CASE("cli layouts: cameras that are given go before that of the file") {
  const TemporaryFolder place;
  place.write("photo.ply", photograph());
  place.write("cameras.json", R"([{"id": 0, "img_name": "a", "width": 20, "height": 10, "fx": 20, "fy": 20,
      "position": [0, 0, 0], "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}])");
  CHECK(swiftgs::test::swiftgs(place, "render photo.ply --cameras cameras.json --format pfm").code == 0);
  CHECK(read_image(place / "renders/a.pfm").width == 20);
}

TEST_CASE("cli layouts: convert moves positions in double before it rounds them") {
  const TemporaryFolder place;
  std::vector<PlyValue> gaussian = red_gaussian();
  property(gaussian, "x") = {"double", "x", 512345.0625};
  property(gaussian, "y") = {"double", "y", 5403209.78125};
  place.write("utm.ply", ply(gaussian));
  place.write("near.ply", ply(red_gaussian()));
  const Outcome outcome =
      swiftgs::test::swiftgs(place,
                             "convert near.ply utm.ply b.ply --transform move:-512345,-5403209,0 "
                             "--transform scale:2");
  CHECK(outcome.code == 0);
  CHECK(outcome.err == "");
  const swiftgs::Scene scene = load_scene(place / "b.ply");
  REQUIRE(scene.size() == 2);
  CHECK(scene.means[1] == vec3(0.125f, 1.5625f, 4));
  CHECK(scene.means[0] == vec3(-1024692, -10806419, 4));
}

TEST_CASE("cli layouts: convert says how far it moves positions by rounding them") {
  const TemporaryFolder place;
  std::vector<PlyValue> gaussian = red_gaussian();
  property(gaussian, "y") = {"double", "y", 5403209.78125};
  place.write("utm.ply", ply(gaussian));
  const std::string start =
      "Positions are so far from the origin that rounding them to float moves them by up ";
  CHECK(
      swiftgs::test::swiftgs(place, "convert utm.ply b.ply").err ==
      "swiftgs: utm.ply: " + start +
          "to 0.219 units of the scene; 'swiftgs convert --transform move:X,Y,Z' moves them before it rounds "
          "them.\n");
  CHECK(swiftgs::test::swiftgs(place, "convert utm.ply b.ply --transform scale:2").err ==
        "swiftgs: b.ply: " + start + "to 0.438 units of the scene.\n");
}
