// SPDX-License-Identifier: Apache-2.0
#include <system_error>

#include <swiftgs/io/cameras.hpp>

#include "camera_parsing.hpp"
#include "files.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// A JSON array of `elements`.
std::string array(const std::string& elements) {
  std::string content = "[";
  content += elements;
  return content += "]";
}

/// A camera at (1, 2, 3), turned by 90 degrees: its x axis is the world's y axis.
std::string camera(const std::string& name) {
  return R"({"id": 0, "img_name": ")" + name +
         R"(", "width": 640, "height": 480, "position": [1, 2.0, 3e0],
             "rotation": [[0, -1, 0], [1, 0, 0], [0, 0, 1]], "fy": 510.5, "fx": 500})";
}

std::string with(std::string content, const std::string& from, const std::string& to) {
  return content.replace(content.find(from), from.size(), to);
}

std::string complaint_about(const std::string& content) {
  return complaint([&] { io::parse_cameras_json({as_bytes(content), "cameras.json"}); });
}

}  // namespace

TEST_CASE("cameras.json: a pose is inverted and the principal point is centred") {
  const TemporaryFolder folder;
  const auto cameras = load_cameras(folder.write("anything", array(camera("a"))));
  REQUIRE(cameras.size() == 1);
  const Camera& c = cameras[0];
  CHECK(c.name == "a");
  CHECK(c.width == 640);
  CHECK(c.height == 480);
  CHECK(c.fx == 500);
  CHECK(c.fy == 510.5);
  CHECK(c.cx == 320);
  CHECK(c.cy == 240);
  CHECK(c.centre() == dvec3(1, 2, 3));
  CHECK(c.rotation * dvec3(0, 1, 0) == dvec3(1, 0, 0));
  CHECK(c.rotation * dvec3(1, 2, 3) + c.translation == dvec3(0));
}

TEST_CASE("cameras.json: cameras are sorted by image name") {
  const TemporaryFolder folder;
  const std::string content = array(camera("b") + ",\n " + camera("c") + " , " + camera("a"));
  const auto cameras = load_cameras(folder.write("cameras.json", content));
  REQUIRE(cameras.size() == 3);
  CHECK(cameras[0].name == "a");
  CHECK(cameras[1].name == "b");
  CHECK(cameras[2].name == "c");
}

TEST_CASE("cameras.json: a file that ends early is refused wherever it ends") {
  check_every_truncation(array(camera("a") + "," + camera("b")), [](const std::string& content) {
    io::parse_cameras_json({as_bytes(content), "cameras.json"});
  });
}

TEST_CASE("cameras.json: the camera that is wrong is placed") {
  const std::string good = array(camera("x,[{\\\"]") + ", " + camera("b"));
  CHECK(complaint_about(good) == "");
  const std::size_t second = good.find(", {") + 2;
  const std::string place = "cameras.json: byte " + std::to_string(second) + ": expected ";
  const auto second_with = [&](const std::string& from, const std::string& to) {
    return good.substr(0, second) + with(good.substr(second), from, to);
  };
  CHECK(complaint_about(second_with("\"fx\"", "\"fz\"")) == place + "a camera with 'fx'");
  CHECK(complaint_about(second_with("500", "\"500\"")) == place + "a number in 'fx'");
  CHECK(complaint_about(second_with("[1, 2.0, 3e0]", "[1, 2.0]")) == place + "three numbers in 'position'");
  CHECK(complaint_about(second_with("[0, 0, 1]", "[0, 0, null]")) == place + "a number in 'rotation'");
  CHECK(complaint_about(second_with(", [0, 0, 1]", "")) == place + "'rotation' to be three rows");
  CHECK(complaint_about(second_with("\"b\"", "7")) == place + "'img_name' to be a string");
  CHECK(contains(complaint_about(second_with("[0, 0, 1]", "[0, 0, 2]")), place));
  CHECK(contains(complaint_about(second_with("500", "-500")), "focal lengths of 1e-6 to 1e12 pixels"));
  for (const char* width : {"0", "-640", "65537", "640.5", "1e300"})
    CHECK(contains(complaint_about(second_with("640", width)), place + "a width"));
}

TEST_CASE("cameras.json: JSON that is something else is refused") {
  CHECK(contains(complaint_about("{}"), "array of cameras"));
  CHECK(contains(complaint_about("[1]"), "byte 1: expected a camera"));
  CHECK(contains(complaint_about("[1, x]"), "byte 4: expected valid JSON"));
  CHECK(contains(complaint_about("[1, "), "byte 4: expected valid JSON"));
  CHECK(contains(complaint_about("[1e999]"), "numbers that a double can hold"));
  CHECK(contains(complaint_about(std::string(100'000, '[')), "valid JSON"));
  const TemporaryFolder folder;
  for (const char* content : {"", "{}", "ply\n"})
    CHECK_THROWS_AS(load_cameras(folder.write("a", content)), FormatError);
  CHECK_THROWS_AS(load_cameras(folder / "missing"), std::system_error);
}
