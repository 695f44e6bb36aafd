// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/io/image.hpp>
#include <swiftgs/io/scene_file.hpp>

#include "cli/cameras.hpp"
#include "cli/command.hpp"
#include "io/far_scene.hpp"
#include "io/ply_text.hpp"

namespace swiftgs::test::layouts_test {

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

TEST_CASE("cli layouts: a photograph's scene is drawn from its own camera unless cameras are given") {
  const TemporaryFolder place;
  place.write("photo.ply", photograph());
  CHECK(run_noting(place, "render photo.ply --format pfm").err ==
        "swiftgs: photo.ply: The file holds the camera of its photograph, of 48x32 pixels.\n");
  const Image image = read_image(place / "renders/view.pfm");
  CHECK(image.width == 48);
  CHECK(image.height == 32);
  CHECK(red_at(image, 14, 11) > 0.6f);  // 24 - 20 / 2, 16 - 10 / 2
  CHECK(red_at(image, 34, 21) < 0.01f);
  run_noting(place, "render photo.ply --format pfm --scale 2");
  CHECK(read_image(place / "renders/view.pfm").width == 96);
  place.write("cameras.json", cameras_json({"a"}));
  run_noting(place, "render photo.ply --cameras cameras.json --format pfm");
  CHECK(read_image(place / "renders/a.pfm").width == 32);
}

namespace {

/// A camera of 160x120 at `place`, of which a millimetre at a distance of 3 is a pixel.
std::string camera_at(const dvec3& place, const std::string& name) {
  return R"([{"id": 0, "img_name": ")" + name + R"(", "width": 160, "height": 120, "fx": 3000, "fy": 3000,
    "position": [)" +
         std::to_string(place.x) + ", " + std::to_string(place.y) + ", " + std::to_string(place.z) +
         R"(], "rotation": [[1, 0, 0], [0, 0, 1], [0, -1, 0]]}])";
}

const dvec3 far(10'000'000, -6'378'137, 4'000'000), from(0.015625, -3, 0.25);

}  // namespace

TEST_CASE("cli layouts: millimetre splats ten thousand kilometres from zero are drawn as beside it") {
  const TemporaryFolder place;
  place.write("near.ply", far_scene(dvec3(0), "float"));
  place.write("far.ply", far_scene(far, "double"));
  place.write("near.json", camera_at(from, "near"));
  place.write("far.json", camera_at(far + from, "far"));
  const std::string note =
      "Positions are too far from zero for float: the scene has them relative to the origin "
      "10000000,-6378137,4000000.\n";
  CHECK(run(place, "render near.ply --cameras near.json --format pfm").err == "");
  CHECK(run_noting(place, "render far.ply --cameras far.json --format pfm").err ==
        "swiftgs: far.ply: " + note);
  const Image near = read_image(place / "renders/near.pfm");
  CHECK(std::count(near.pixels.begin(), near.pixels.end(), 0.0f) < std::ptrdiff_t(near.pixels.size()));
  CHECK(near.pixels == read_image(place / "renders/far.pfm").pixels);

  // What is judged by cameras.
  run_noting(place, "prune far.ply --out far-pruned.ply --cameras far.json --views 0 --keep 0.5");
  run(place, "prune near.ply --out near-pruned.ply --cameras near.json --views 0 --keep 0.5");
  CHECK(load_scene(place / "far-pruned.ply").means == load_scene(place / "near-pruned.ply").means);

  check_holds(run(place, "info far.ply").out, {"note            " + note});
  check_holds(run(place, "info far.ply --json -").out, {"\"origin\": [10000000.0,-6378137.0,4000000.0]"});
}

}  // namespace swiftgs::test::layouts_test
