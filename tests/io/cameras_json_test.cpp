// SPDX-License-Identifier: Apache-2.0
#include <system_error>

#include "camera_files.hpp"
#include "camera_parsing.hpp"

namespace swiftgs::test::cameras_json_test {

namespace {

std::string array(const std::string& elements) { return "[" + elements + "]"; }

/// A camera at (1, 2, 3), turned by 90 degrees: its x axis is the world's y axis.
std::string camera(const std::string& name) {
  return R"({"id": 0, "img_name": ")" + name +
         R"(", "width": 640, "height": 480, "position": [1, 2.0, 3e0],
             "rotation": [[0, -1, 0], [1, 0, 0], [0, 0, 1]], "fy": 510.5, "fx": 500})";
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
  CHECK(intrinsics(c) == Intrinsics{640, 480, 500, 510.5, 320, 240});
  CHECK(c.centre() == dvec3(1, 2, 3));
  CHECK(c.rotation * dvec3(0, 1, 0) == dvec3(1, 0, 0));
  CHECK(c.rotation * dvec3(1, 2, 3) + c.translation == dvec3(0));
}

TEST_CASE("cameras.json: cameras are sorted by image name") {
  const TemporaryFolder folder;
  const std::string content = array(camera("b") + ",\n " + camera("c") + " , " + camera("a"));
  const auto cameras = load_cameras(folder.write("cameras.json", content));
  REQUIRE(cameras.size() == 3);
  CHECK(cameras[0].name + cameras[1].name + cameras[2].name == "abc");
}

TEST_CASE("cameras: a file that ends early is refused wherever it ends") {
  check_every_truncation(array(camera("a") + "," + camera("b")), [](const std::string& content) {
    io::parse_cameras_json({as_bytes(content), "cameras.json"});
  });
  const std::string matrix = R"([[1, 0, 0, 1], [0, 1, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]])";
  check_every_truncation(
      R"({"cx": 321, "cy": 239.25, "fl_x": 500, "fl_y": 510.5, "frames": [{"file_path": "b.jpg",
          "transform_matrix": )" +
          matrix + R"(}, {"file_path": "a.jpg", "transform_matrix": )" + matrix +
          R"(}], "h": 480.0, "w": 640})",
      [](const std::string& content) {
        io::parse_transforms_json({as_bytes(content), "transforms.json"});
      });
  check_every_truncation(
      R"({"camera_path": [{"camera_to_world": [1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3, 0, 0, 0, 1], "fov": 90.0}],
          "camera_type": "perspective", "render_height": 48, "render_width": 64})",
      [](const std::string& content) {
        io::parse_camera_path({as_bytes(content), "camera_path.json"});
      });
  const std::string cameras = cameras_bin({{}, {.id = 2}}), images = images_bin({{}, {.name = "b"}});
  check_every_truncation(cameras, [&](const std::string& part) { parse_binary(part, images); });
  check_every_truncation(images, [&](const std::string& part) { parse_binary(cameras, part); });
}

TEST_CASE("cameras.json: the camera that is wrong is placed") {
  const std::string good = array(camera("x,[{\\\"]") + ", " + camera("b"));
  CHECK(complaint_about(good) == "");
  const std::size_t second = good.find(", {") + 2;
  const std::string place = "cameras.json: byte " + std::to_string(second) + ": expected ";
  const auto second_with = [&](const std::string& from, const std::string& to) {
    return good.substr(0, second) + with(good.substr(second), from, to);
  };
  const char* cases[][3] = {{"\"fx\"", "\"fz\"", "a camera with 'fx'"},
                            {"500", "\"500\"", "a number in 'fx'"},
                            {"[1, 2.0, 3e0]", "[1, 2.0]", "three numbers in 'position'"},
                            {"[0, 0, 1]", "[0, 0, null]", "a number in 'rotation'"},
                            {", [0, 0, 1]", "", "'rotation' to be three rows"},
                            {"\"b\"", "7", "'img_name' to be a string"}};
  for (const auto& [from, to, expected] : cases)
    CHECK(complaint_about(second_with(from, to)) == place + expected);
  CHECK(contains(complaint_about(second_with("[0, 0, 1]", "[0, 0, 2]")), place));
  CHECK(contains(complaint_about(second_with("500", "-500")), "focal lengths of 1e-6 to 1e12 pixels"));
  for (const char* width : {"0", "-640", "65537", "640.5", "1e300"})
    CHECK(contains(complaint_about(second_with("640", width)), place + "a width"));
}

TEST_CASE("cameras.json: JSON that is something else is refused") {
  const std::pair<std::string, const char*> cases[] = {
      {"{}", "array of cameras"},
      {"[1]", "byte 1: expected a camera"},
      {"[1, x]", "byte 4: expected valid JSON"},
      {"[1, ", "byte 4: expected valid JSON"},
      {"[1e999]", "numbers that a double can hold"},
      {std::string(100'000, '['), "at most 256 arrays and objects in each other"}};
  for (const auto& [content, expected] : cases) CHECK(contains(complaint_about(content), expected));
  const TemporaryFolder folder;
  for (const char* content : {"", "{}", "ply\n"})
    CHECK_THROWS_AS(load_cameras(folder.write("a", content)), FormatError);
  CHECK_THROWS_AS(load_cameras(folder / "missing"), std::system_error);
}

}  // namespace swiftgs::test::cameras_json_test
