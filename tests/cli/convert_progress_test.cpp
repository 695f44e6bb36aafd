// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <sys/stat.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/io/scene_file.hpp>

#include "cli/background_run.hpp"

namespace swiftgs::test::convert_progress_test {

const std::set<std::string> no_result = {"stdout.txt"};  // of the tool itself

TEST_CASE("cli convert: a terminal shows what is done and is clean at the end") {
  const TemporaryFolder place;
  write_scene(place / "a.ply", swiftgs::make_builtin_scene(300));
  BackgroundRun tool(place, {"convert", "a.ply", "builtin:10", "b.ply", "--degree", "1", "--order"});
  CHECK(tool.wait() == 0);
  std::size_t before = 0;
  for (const char* part : {"] 0/300 read a.ply", "] 100/300", " read builtin:10", " --degree 1", " --order",
                           "] 200/300", " write b.ply", "] 300/300"}) {
    CAPTURE(part);
    const std::size_t at = tool.shown().find(part, before);
    REQUIRE(at != std::string::npos);
    before = at;
  }
  CHECK(tool.shown().ends_with("\r\x1b[K"));
  CHECK(contains(content_of(place / "stdout.txt"), "\nwritten "));
}

TEST_CASE("cli convert: Ctrl-C between edits leaves the others out and no file") {
  const TemporaryFolder place;
  std::vector<std::string> arguments{"convert", "builtin:100000", "b.ply", "--order"};
  for (int i = 0; i < 1000; ++i) arguments.insert(arguments.end(), {"--transform", "rotate:0,0,1,1"});
  BackgroundRun tool(place, arguments);
  REQUIRE(tool.shows("--transform rotate"));
  tool.press_ctrl_c();
  CHECK(tool.wait() == 1);
  CHECK(contains(tool.shown(), "b.ply: cancelled"));
  CHECK(!contains(tool.shown(), "--order"));
  CHECK(files_in(place.path()) == no_result);
}

TEST_CASE("cli convert: Ctrl-C while a file is written leaves no part of it") {
  const TemporaryFolder place;
  BackgroundRun tool(place, {"convert", "builtin:30000", "b.sog"});
  REQUIRE(tool.shows("write b.sog"));
  tool.press_ctrl_c();
  CHECK(tool.wait() == 1);
  CHECK(contains(tool.shown(), "b.sog: cancelled"));
  CHECK(files_in(place.path()) == no_result);
}

TEST_CASE("cli convert: a tool that was started to ignore Ctrl-C goes on and one that was not stops") {
  const TemporaryFolder place;
  write_scene(place / "a.ply", swiftgs::make_builtin_scene(1000));
  write_scene(place / "whole.ply", swiftgs::load_scene(place / "a.ply"));
  for (const bool ignored : {false, true}) {
    CAPTURE(ignored);
    std::filesystem::remove(place / "pipe");
    REQUIRE(::mkfifo((place / "pipe").c_str(), 0600) == 0);
    BackgroundRun tool(place, {"convert", "a.ply", "pipe", "--format", "ply"},
                       ignored ? BackgroundRun::CtrlC::is_ignored : BackgroundRun::CtrlC::ends_it);
    std::ifstream pipe(place / "pipe", std::ios::binary);  // opens when the tool begins to write
    tool.press_ctrl_c();
    const std::string written{std::istreambuf_iterator<char>(pipe), {}};
    CHECK(tool.wait() == (ignored ? 0 : 1));
    // A tool that stops may have written what it had encoded.
    if (ignored) CHECK((written == content_of(place / "whole.ply")));
  }
}

}  // namespace swiftgs::test::convert_progress_test
