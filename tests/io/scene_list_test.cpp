// SPDX-License-Identifier: Apache-2.0
#include "scene_list.hpp"

#include <cmath>
#include <cstddef>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include <swiftgs/edit/rotation.hpp>
#include <swiftgs/io/scene_list.hpp>

#include "files.hpp"

namespace swiftgs::test::scene_list_test {

namespace {

std::vector<ListedScene> parse(const std::string& content) {
  return io::parse_scene_list({as_bytes(content), "scenes.json"});
}

std::string complaint_about(const std::string& content) {
  return complaint([&] { parse(content); });
}

/// A list of one scene with these members beside its file.
std::string with_members(const std::string& members) { return "[{\"file\": \"a.ply\", " + members + "}]"; }

const std::string whole = R"([{"file": "room.spz"},
  {"file": "things/chair.ply", "rotation": [0, 0, 3, 0], "scale": 0.5, "translation": [1e7, -2.5, 3],
   "opacity": 0.25, "clip": {"half_spaces": [[1, 2, -3, 4], [0, 0, 1, -1]], "sphere": [1, 2, 3, 4.5]}},
  {"rotation": [[0, -1, 0], [1, 0, 0], [0, 0, 1]], "clip": {"box": [-1, -2, -3, 4, 5, 6]}, "file": "room.spz",
   "first": 256, "count": 3e3, "tint": [1, 0.5, 0, 0.75], "visible": false}])";

}  // namespace

TEST_CASE("scene list: a file is one by its content, whatever its name") {
  const TemporaryFolder folder;
  CHECK(is_scene_list(folder.write("scenes.json", whole)));
  CHECK(is_scene_list(folder.write("marked.txt", "\xef\xbb\xbf\r\n " + whole)));
  for (const std::string other : {R"([{"img_name": "a", "file": 1}])", R"({"file": "a.ply"})", "[1]", "",
                                  "\xef\xbb[{\"file\": \"a.ply\"}]", "ply\n[\"file\""})
    CHECK_FALSE(is_scene_list(folder.write("other.json", other)));
  CHECK_FALSE(is_scene_list(folder.path()));
  CHECK_FALSE(is_scene_list(folder.path() / "none.json"));
}

TEST_CASE("scene list: scenes have what their objects say and the defaults of what they do not") {
  const TemporaryFolder folder;
  const std::vector<ListedScene> scenes = read_scene_list(folder.write("scenes.json", whole));
  REQUIRE(scenes.size() == 3);
  CHECK(scenes[0].file == "room.spz");
  CHECK(scenes[0].world_from_scene.is_identity());
  CHECK(scenes[0].opacity == 1);
  CHECK(scenes[0].tint.is_none());
  CHECK(scenes[0].visible);
  CHECK(scenes[0].first == 0);
  CHECK_FALSE(scenes[0].count);
  CHECK(scenes[0].half_spaces.empty());
  CHECK_FALSE(scenes[0].sphere);

  const ListedScene& chair = scenes[1];
  CHECK(chair.file == "things/chair.ply");
  CHECK(chair.world_from_scene(dvec3(2, 4, 6)) == dvec3(1e7 - 1, -0.5, 0));  // half a turn about y
  CHECK(chair.opacity == 0.25f);
  REQUIRE(chair.half_spaces.size() == 2);
  CHECK(chair.half_spaces[0].normal == dvec3(1, 2, -3));
  CHECK(chair.half_spaces[0].offset == 4);
  REQUIRE(chair.sphere);
  CHECK(chair.sphere->centre == dvec3(1, 2, 3));
  CHECK(chair.sphere->radius == 4.5);

  const ListedScene& turned = scenes[2];
  CHECK(turned.first == 256);
  CHECK(turned.count == 3000);
  CHECK(turned.tint.colour == vec3(1, 0.5f, 0));
  CHECK(turned.tint.amount == 0.75f);
  CHECK_FALSE(turned.visible);
  CHECK(turned.world_from_scene(dvec3(1, 2, 3)) == dvec3(-2, 1, 3));
  REQUIRE(turned.half_spaces.size() == 6);
  const auto shows = [&](const dvec3& p) {
    for (const HalfSpace& half : turned.half_spaces)
      if (!half.contains(p)) return false;
    return true;
  };
  for (const dvec3 inside : {dvec3(-1, -2, -3), dvec3(4, 5, 6), dvec3(0, 0, 0)}) CHECK(shows(inside));
  for (const dvec3 outside : {dvec3(-1.1, 0, 0), dvec3(0, 5.1, 0), dvec3(0, 0, -3.1), dvec3(0, 0, 6.1)})
    CHECK_FALSE(shows(outside));
}

TEST_CASE("scene list: what is written reads as the same scenes") {
  const TemporaryFolder folder;
  std::vector<ListedScene> scenes = parse(whole);
  scenes[1].world_from_scene.rotation = matrix_of(unit({0.3, -0.1, 0.7, 0.2}));
  scenes[1].world_from_scene.scale = 1.0 / 3, scenes[1].world_from_scene.translation.y = 1e7 + 1.0 / 7;
  scenes[1].tint = {vec3(0.1f, 1, 0.7f), 0.3f};
  scenes[1].opacity = 0.1f, scenes[1].sphere->radius = 0.1;
  scenes[2].half_spaces = half_spaces_of({dvec3(-0.1, 0, 1.0 / 3), dvec3(0, 0, 1e7)});
  const auto file = folder / "written.json";
  write_scene_list(file, scenes);
  const std::vector<ListedScene> again = read_scene_list(file);
  REQUIRE(again.size() == scenes.size());
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const ListedScene &a = again[i], &b = scenes[i];
    CHECK(a.file == b.file);
    CHECK(a.world_from_scene.rotation == b.world_from_scene.rotation);
    CHECK(a.world_from_scene.scale == b.world_from_scene.scale);
    CHECK(a.world_from_scene.translation == b.world_from_scene.translation);
    CHECK(a.opacity == b.opacity);
    CHECK(a.tint.colour == b.tint.colour);
    CHECK(a.tint.amount == b.tint.amount);
    CHECK(a.visible == b.visible);
    CHECK(a.first == b.first);
    CHECK(a.count == b.count);
    REQUIRE(a.half_spaces.size() == b.half_spaces.size());
    for (std::size_t k = 0; k < a.half_spaces.size(); ++k) {
      CHECK(a.half_spaces[k].normal == b.half_spaces[k].normal);
      CHECK(a.half_spaces[k].offset == b.half_spaces[k].offset);
    }
    REQUIRE(a.sphere.has_value() == b.sphere.has_value());
    if (!a.sphere) continue;
    CHECK(a.sphere->centre == b.sphere->centre);
    CHECK(a.sphere->radius == b.sphere->radius);
  }
  CHECK(contains(content_of(file), R"({"file":"room.spz"})"));  // no defaults
  CHECK(contains(content_of(file), R"("box":[-0.1,0.0,0.)"));
}

TEST_CASE("scene list: what the reader refuses is not written") {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.write("kept.json", "before");
  const auto refuses = [&](const auto& spoil, const std::string& message) {
    std::vector<ListedScene> scenes{{.file = "a.ply"}, {.file = "b.ply"}};
    spoil(scenes[1]);
    CHECK_THROWS_WITH_AS(write_scene_list(file, scenes), (file.string() + ": " + message).c_str(),
                         std::invalid_argument);
    CHECK(content_of(file) == "before");
  };
  const double endless = INFINITY;
  refuses([](ListedScene& s) { s.world_from_scene.scale = 0; },
          "'b.ply': placed scene: expected a finite scale above 0");
  refuses(
      [&](ListedScene& s) {
        s.half_spaces = half_spaces_of({dvec3(-endless), dvec3(1)});
      },
      "'b.ply': expected a half-space with a finite offset");
  refuses([](ListedScene& s) { s.half_spaces.resize(7); }, "'b.ply': expected at most 6 half-spaces");
  refuses(
      [](ListedScene& s) {
        s.sphere = {dvec3(0), -1};
      },
      "'b.ply': crop: expected a sphere with a finite radius of 0 or more");
  refuses([](ListedScene& s) { s.count = 0; }, "'b.ply': expected a name, and 1 Gaussian or more");
  refuses([](ListedScene& s) { s.file = "\xff.ply"; }, "'\xff.ply': expected a name in UTF-8");
  CHECK_THROWS_WITH_AS(write_scene_list(file, {}),
                       (file.string() + ": expected a scene or more to write").c_str(),
                       std::invalid_argument);
}

TEST_CASE("scene list: the box of six half-spaces is told and other half-spaces are left alone") {
  const Box box{{-1, -2, -3}, {1, 2, 4}};
  std::vector<HalfSpace> sides = half_spaces_of(box);
  REQUIRE(box_of(sides));
  CHECK(box_of(sides)->low == box.low);
  CHECK(box_of(sides)->high == box.high);
  sides[3].normal.x = 0.5;
  CHECK_FALSE(box_of(sides));
  CHECK_FALSE(box_of({}));
  CHECK_FALSE(box_of(half_spaces_of({dvec3(1), dvec3(-1)})));  // the reader refuses it as a box
}

TEST_CASE("scene list: a file that ends early or is damaged is refused or read") {
  check_every_truncation(whole, [](const std::string& content) { parse(content); });
  for (const char flip : {'\1', '\4', '@'})
    check_every_damage(whole, flip, [](const std::string& content) { parse(content); });
}

TEST_CASE("scene list: what is wrong is named with its place") {
  const auto says = [](const std::string& content, const std::string& message) {
    CHECK(complaint_about(content) == "scenes.json: " + message);
  };
  const std::string a_list = "byte 0: expected an array of one scene or more, each an object with 'file'";
  says("{}", a_list), says("[]", a_list), says("3", a_list);
  says("[3]", "byte 1: expected a scene (a JSON object)");
  says("[{}]", "byte 1: expected a scene with 'file'");
  says(R"([{"file": ""}])", "byte 1: expected a name in 'file'");
  says(R"([{"file": "a"}, {"file": 3}])", "byte 16: expected 'file' to be a string");
  const auto refuses = [&](const std::string& members, const std::string& message) {
    says(with_members(members), "byte 1: expected " + message);
  };
  refuses(R"("opacty": 1)",
          "the members file, rotation, scale, translation, opacity, tint, visible, first, count, clip, found "
          "'opacty'");
  refuses(R"("first": -1)", "'first' to be a whole number of at least 0");
  refuses(R"("first": 0.5)", "'first' to be a whole number of at least 0");
  refuses(R"("count": "all")", "'count' to be a whole number of at least 0");
  refuses(R"("count": 0)", "'count' to be 1 or more");
  refuses(R"("opacity": 1.5)", "an opacity of 0 to 1");
  refuses(R"("opacity": "no")", "a number in 'opacity'");
  refuses(R"("tint": [1, 0, 0, 1.5])", "a tint with an amount of 0 to 1");
  refuses(R"("tint": [1, 1e39, 0, 1])", "a tint with a finite colour of 0 or more");
  refuses(R"("tint": [1, 0, 0])", "4 numbers in 'tint'");
  refuses(R"("visible": 1)", "true or false in 'visible'");
  refuses(R"("scale": 0)", "a finite scale above 0");
  refuses(R"("translation": [1, 2])", "three numbers in 'translation'");
  refuses(R"("rotation": [1, 2])", "'rotation' to be a quaternion w, x, y, z or three rows of three numbers");
  refuses(R"("rotation": [0, 0, 0, 0])", "a quaternion other than 0 in 'rotation'");
  refuses(R"("rotation": [1, 2, 3])", "three numbers in 'rotation'");
  refuses(R"("rotation": [1, 2, 3, "x"])", "4 numbers in 'rotation'");
  refuses(R"("rotation": [[2, 0, 0], [0, 1, 0], [0, 0, 1]])", "a rotation with orthonormal columns");
  const auto refuses_clip = [&](const std::string& clip, const std::string& message) {
    says(with_members("\"clip\": " + clip), "byte 27: expected " + message);
  };
  refuses_clip("3", "a clip (a JSON object)");
  refuses_clip(R"({"ball": []})", "the members box, sphere, half_spaces, found 'ball'");
  refuses_clip(R"({"box": [1, 2, 3]})", "6 numbers in 'box'");
  refuses_clip(R"({"box": [1, 0, 0, 0, 1, 1]})", "a box whose first corner is the lower one");
  refuses_clip(R"({"sphere": [1, 2, 3, -4]})", "a sphere with a finite radius of 0 or more");
  refuses_clip(R"({"half_spaces": 3})", "'half_spaces' to be an array");
  refuses_clip(R"({"half_spaces": [[0, 0, 0, 1]]})", "a half-space with a finite normal other than 0");
  refuses_clip(R"({"half_spaces": [[0, 1, 0, 1]], "box": [0, 0, 0, 1, 1, 1]})",
               "at most 6 half-spaces, of which a box is six");
}

}  // namespace swiftgs::test::scene_list_test
