// SPDX-License-Identifier: Apache-2.0
#include "camera_files.hpp"

namespace swiftgs::test::colmap_test {

namespace {

const std::string cameras_txt =
    "# Camera list\n1 PINHOLE 640 480 500 510 321 239\r\n\n2 SIMPLE_PINHOLE 64 48 50 32 24\n";
const std::string images_txt =
    "# Image list\n#   POINTS2D[]\n"
    "1 2 0 0 2 1 2 3 1 z.jpg\n10 20 -1 30 40 7\n"
    "2 1 0 0 0 0 0 0 2 a name.jpg\n\n"
    "3 1 0 0 0 0 0 1 1 b.jpg\n";

void check_first(const Camera& c) {
  CHECK(intrinsics(c) == Intrinsics{640, 480, 500, 510, 321, 239});
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
  CHECK(intrinsics(result[1]) == Intrinsics{64, 48, 50, 50, 32, 24});
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
  const dvec3 turned = glm::cross(u, v);
  const dvec3 expected = v + 2 * w * turned + 2.0 * glm::cross(u, turned), found = camera.rotation * v;
  for (int axis = 0; axis < 3; ++axis) CHECK(found[axis] == doctest::Approx(expected[axis]).epsilon(1e-12));
}

TEST_CASE("colmap: cameras of a folder are sorted by name and binary wins") {
  const TemporaryFolder folder;
  folder.write("text/cameras.txt", cameras_txt);
  folder.write("text/images.txt", images_txt);
  const auto text = load_cameras(folder / "text");
  REQUIRE(text.size() == 3);
  CHECK(text[0].name == "a name.jpg");
  CHECK(text[2].name == "z.jpg");

  folder.write("text/cameras.bin", cameras_bin({{}}));
  CHECK(load_cameras(folder / "text").size() == 3);
  folder.write("text/images.bin", images_bin({{}}));
  CHECK(load_cameras(folder / "text").size() == 1);
}

TEST_CASE("colmap: a text file that ends early never crashes") {
  for (std::size_t length = 0; length < images_txt.size(); ++length)
    CHECK_NOTHROW(complaint([&] { parse_text(cameras_txt, images_txt.substr(0, length)); }));
  // The last number may be shorter than it was.
  for (std::size_t length = 0; length + 2 < cameras_txt.size(); ++length)
    CHECK(complaint([&] { parse_text(cameras_txt.substr(0, length), images_txt); }) != "");
}

TEST_CASE("colmap: counts that the file cannot hold are refused before memory is taken") {
  const std::string cameras = cameras_bin({{}}), images = images_bin({{}});
  for (const std::uint64_t count : {std::uint64_t(2), std::uint64_t(1) << 40, ~std::uint64_t(0)}) {
    CHECK(complaint([&] { parse_binary(with(cameras, 0, count), images); }) != "");
    CHECK(complaint([&] { parse_binary(cameras, with(images, 0, count)); }) != "");
  }
  CHECK(contains(complaint([&] { parse_binary(cameras, with(images, 0, std::uint64_t(0))); }),
                 "end of the file"));
  for (const std::uint64_t points : {std::uint64_t(3), ~std::uint64_t(0) / 24 + 1, ~std::uint64_t(0)})
    CHECK(contains(complaint([&] { parse_binary(cameras, images_bin({{.points = points}})); }), "points"));
}

TEST_CASE("colmap: values that make no camera are refused") {
  const std::pair<ColmapCamera, const char*> cameras[] = {
      {{.width = 0}, "a width and a height"},
      {{.height = ~std::uint64_t(0)}, "a width and a height"},
      {{.parameters = {-1, 1, 1, 1}}, "focal lengths of 1e-6 to 1e12 pixels"},
      {{.parameters = {1, 1, NAN, 1}}, "principal point"},
      {{.id = 3}, "images.bin: byte 8: expected the id of a known camera, found 1"}};
  for (const auto& one : cameras)
    CHECK(contains(complaint([&] { parse_binary(cameras_bin({one.first}), images_bin({{}})); }), one.second));
  CHECK(contains(complaint([] { parse_binary(cameras_bin({{}, {}}), images_bin({{}})); }), "once"));
  const std::pair<ColmapImage, const char*> images[] = {
      {{.pose = {0, 0, 0, 0, 1, 2, 3}}, "quaternion"},
      {{.pose = {NAN, 0, 0, NAN, 1, 2, 3}}, "quaternion"},
      {{.pose = {INFINITY, 0, 0, INFINITY, 1, 2, 3}}, "quaternion"},
      {{.pose = {2, 0, 0, 2, 1, NAN, 3}}, "translation"}};
  for (const auto& one : images)
    CHECK(contains(complaint([&] { parse_binary(cameras_bin({{}}), images_bin({one.first})); }), one.second));
}

TEST_CASE("colmap: text that is no camera and no image is placed") {
  const std::string good = "1 PINHOLE 640 480 1 2 3 4";
  const std::pair<std::string, const char*> cameras[] = {
      {"x PINHOLE 640 480 1 2 3 4", "cameras.txt: byte 6: expected a number for a camera id"},
      {"1 PINHOLE 640 480 1 2 3", "camera parameter"},
      {good + " 5", "found more"},
      {"1 PINHOLE 640.5 480 1 2 3 4", "a width"},
      {good + "\n" + good, "once"}};
  for (const auto& one : cameras)
    CHECK(contains(complaint([&] { parse_text("# one\n" + one.first + "\n", images_txt); }), one.second));
  const char* images[][2] = {{"1 1 0 0 0 0 0 0 5 a.jpg", "known camera, found 5"},
                             {"1 1 0 0 0 0 0 0 1", "image name"},
                             {"1 1 0 0 0 0 0 nothing 1 a", "a pose"},
                             {"1 0 0 0 0 0 0 0 1 a", "quaternion"}};
  for (const auto& one : images)
    CHECK(contains(complaint([&] { parse_text(cameras_txt, std::string(one[0]) + "\n\n"); }), one[1]));
}

}  // namespace swiftgs::test::colmap_test
