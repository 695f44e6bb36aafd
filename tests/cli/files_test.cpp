// SPDX-License-Identifier: Apache-2.0
#include "support/files.hpp"

#include <cstdlib>
#include <stdexcept>
#include <string>
#include <system_error>

#include <doctest/doctest.h>

#include "read/distinct_files.hpp"
#include "read/placed_input.hpp"
#include "result_file.hpp"
#include "words.hpp"

using namespace swiftgs::cli;
using swiftgs::cli::shell_word;
using swiftgs::test::content_of;
using swiftgs::test::TemporaryFolder;

TEST_CASE("result file: what was there stays until the first results") {
  const TemporaryFolder place;
  place.write("results.json", "old");
  ResultFile file((place / "results.json").string());
  CHECK(content_of(place / "results.json") == "old");
  file.write("new");
  CHECK(content_of(place / "results.json") == "new");
  CHECK_THROWS_AS(ResultFile((place / "missing/results.json").string()), std::system_error);
  ResultFile none("");
  none.write("nowhere");
}

TEST_CASE("distinct files: one file has many names") {
  const TemporaryFolder place;
  const std::string file = place.write("a.json", "").string(), folder = place.path().string();
  std::filesystem::create_symlink("a.json", place / "link.json");
  std::filesystem::create_hard_link(place / "a.json", place / "hard.json");
  for (const std::string name : {"/a.json", "/./a.json", "/none/../a.json", "/link.json", "/hard.json"}) {
    CAPTURE(name);
    CHECK(is_same_file(file, folder + name));
    CHECK(is_same_file(folder + name, file));
  }
  CHECK_FALSE(is_same_file(file, folder + "/b.json"));
  CHECK(is_same_file(folder + "/b.json", folder + "/none/../b.json"));  // neither is there yet
  CHECK(is_same_file("b.json", "./b.json"));
  CHECK_FALSE(is_same_file("/dev/null", "/dev/null"));
}

TEST_CASE("distinct files: an output that is an input or an output before is named with both options") {
  CHECK_NOTHROW(require_distinct({{"--out", "a"}, {"--json", "b"}}, {{"SCENE", "c"}, {"--cameras", "c"}}));
  CHECK_NOTHROW(require_distinct({{"--out", ""}, {"--json", ""}}, {{"SCENE", ""}}));
  CHECK_THROWS_WITH_AS(require_distinct({{"--out", "a"}, {"--json", "./c"}}, {{"SCENE", "c"}}),
                       "--json ./c: expected another file than that of SCENE, c", std::invalid_argument);
  CHECK_THROWS_WITH_AS(require_distinct({{"--out", "a"}, {"--json", "a"}}, {{"SCENE", "c"}}),
                       "--json a: expected another file than that of --out", std::invalid_argument);
}

TEST_CASE("cli placed: what a list says is placed relative to the origins of the scene and of the world") {
  using swiftgs::dvec3;
  const swiftgs::dmat3 turn{dvec3(0, 0, -1), dvec3(0, 1, 0), dvec3(1, 0, 0)};
  const swiftgs::ListedScene listed{.file = "a.ply",
                                    .world_from_scene = {turn, 2, dvec3(1, 2, 3)},
                                    .opacity = 0.5f,
                                    .tint = {swiftgs::vec3(1, 2, 3), 0.25f},
                                    .half_spaces = {{dvec3(0, 2, 0), 5}, {dvec3(1, 0, 0), -1}},
                                    .sphere = swiftgs::Sphere{dvec3(101, 2, 3), 4},
                                    .first = 6,
                                    .count = 7};
  const swiftgs::Placement p = placement_of(listed, 3, dvec3(100, 10, 0), dvec3(0, 20, 0));
  CHECK(p.scene == 3);
  CHECK(p.world_from_scene.rotation == turn);
  CHECK(p.world_from_scene.scale == 2);
  CHECK(p.world_from_scene.translation == dvec3(1, 2, -197));  // of the origin, less the world's
  CHECK(p.opacity == 0.5f);
  CHECK(p.tint.colour == swiftgs::vec3(1, 2, 3));
  CHECK(p.tint.amount == 0.25f);
  CHECK(p.clip.half_space_count == 2);
  CHECK(p.clip.half_spaces[0] == swiftgs::vec4(0, 2, 0, 15));
  CHECK(p.clip.half_spaces[1] == swiftgs::vec4(1, 0, 0, 101));
  CHECK(p.clip.centre == swiftgs::vec3(1, -8, 3));
  CHECK(p.clip.radius == 4);
  CHECK(p.first == 6);
  CHECK(p.count == 7);
  CHECK(placement_of({.file = "a.ply", .visible = false}, 0, dvec3(0), dvec3(0)).count == 0);
}

TEST_CASE("shell word: a plain word stays, an empty one is quoted, and a shell gives back every character") {
  CHECK(shell_word("a/b_c.json:8=1,2@%+-") == "a/b_c.json:8=1,2@%+-");
  CHECK(shell_word("") == "''");
  CHECK(shell_word("~") == "'~'");
  const TemporaryFolder place;
  std::string text = "'";
  for (int c = 1; c < 256; ++c) text += char(c);
  text += "''";
  const std::string command =
      "printf %s " + shell_word(text) + " >" + shell_word((place / "told.txt").string());
  REQUIRE(std::system(command.c_str()) == 0);
  CHECK(content_of(place / "told.txt") == text);
}
