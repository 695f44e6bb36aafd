// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <set>
#include <string>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/version.hpp>

#include "cli/cameras.hpp"
#include "cli/command.hpp"
#include "cli/json_in.hpp"
#include "support/ply_numbers.hpp"

namespace swiftgs::test::json_test {

namespace {

const std::string one = " --renderers serial/early/per-pixel/ellipse";

struct Command {
  std::string name, arguments;
  bool prints_beside = true;  ///< text that is no part of the results
};

/// One of each command that has results.
const Command commands[] = {
    {"info", "info builtin:50", false},
    {"list", "list", false},
    {"render", "render builtin:50 --scale 0.02 --views 0-1 --stats"},
    {"check", "check builtin:50 --scale 0.02 --repeats 1" + one},
    {"bench", "bench builtin:50 --scales 0.05 --views 0 --min-frames 2 --max-frames 2" + one},
    {"prune", "prune builtin:50 --keep 0.5 --out small.ply --scale 0.02 --backend serial"},
    {"convert", "convert builtin:50 small.ply", false},
    {"stress",
     "stress --families needles --severity 100 --seeds 1 --renderers serial/early/per-pixel/ellipse"},
};

}  // namespace

TEST_CASE("cli json: the results of every command have the same head and no path of the machine") {
  for (const auto& [name, arguments, prints_beside] : commands) {
    CAPTURE(arguments);
    const TemporaryFolder place;
    run(place, arguments + " --json results.json");
    const std::string text = content_of(place / "results.json");
    CHECK(text.starts_with("{\"format\": \"swiftgs-" + name + "\", \"version\": 1,\n\"machine\": {\"date\""));
    const json results = json::parse(text);
    CHECK(results["machine"]["version"] == swiftgs::version);
    CHECK(results["command"].get<std::string>().starts_with("swiftgs " + arguments.substr(0, 6)));
    CHECK_FALSE(contains(text, place.path().string()));
    CHECK_FALSE(contains(text, std::filesystem::path(SWIFTGS_CLI).parent_path().string()));
  }
}

TEST_CASE("cli json: a dash puts the results and nothing else on standard output") {
  for (const auto& [name, arguments, prints_beside] : commands) {
    CAPTURE(arguments);
    const TemporaryFolder place;
    const Outcome outcome = run_noting(place, arguments + " --json -");
    REQUIRE(json::accept(outcome.out));
    CHECK(json::parse(outcome.out)["format"] == "swiftgs-" + name);
    CHECK((outcome.err != "") == prints_beside);
    CHECK_FALSE(std::filesystem::exists(place / "-"));
  }
}

TEST_CASE("cli json: info says what it prints") {
  const TemporaryFolder place;
  write_scene(place / "scene.ply", swiftgs::make_builtin_scene(10));
  constexpr std::size_t x = 0;
  set_ply_number(place / "scene.ply", 10, 3, x, std::numeric_limits<float>::quiet_NaN());
  const json info = json::parse(run(place, "info scene.ply --json -").out);
  CHECK(members_of(info) ==
        std::set<std::string>{
            "format",    "version",        "machine", "command", "scene",     "cameras",     "lenses",
            "photos",    "file_format",    "bytes",   "seconds", "gaussians", "stored",      "dropped",
            "sh_degree", "used_sh_degree", "model",   "origin",  "notes",     "percentiles", "harmonics"});
  CHECK(info["harmonics"] == json({{"kept", "floats"}, {"bytes_a_gaussian", 192}}));
  check_members(info, R"({"scene": "scene", "cameras": null, "gaussians": 9, "stored": 10, "dropped": 1})");
  CHECK(info["sh_degree"] == 3);
  CHECK(info["file_format"] == "INRIA PLY (binary_little_endian)");
  CHECK(info["bytes"] == std::filesystem::file_size(place / "scene.ply"));
  CHECK(info["seconds"] > 0);
  CHECK(info["seconds"] < 60);
  CHECK(json::parse(run(place, "info builtin:10 --json -").out)["bytes"].is_null());
  const json& percentiles = info["percentiles"];
  CHECK(percentiles["percent"] == json({0, 1, 10, 25, 50, 75, 90, 99, 100}));
  for (const char* member : {"x", "y", "z", "opacity", "longest_scale", "middle_scale", "shortest_scale"}) {
    REQUIRE(percentiles[member].size() == 9);
    for (std::size_t i = 1; i < 9; ++i) CHECK(percentiles[member][i - 1] <= percentiles[member][i]);
  }
  CHECK(percentiles["longest_scale"][8] > percentiles["shortest_scale"][8]);
}

TEST_CASE("cli json: render has a row for each image with what it prints of it") {
  const TemporaryFolder place;
  run(place, "render builtin:50 --scale 0.02 --views 0-1 --json plain.json --out a/b");
  const json rows = json_in(place / "plain.json")["rows"];
  REQUIRE(rows.size() == 2);
  CHECK_FALSE(rows[0].contains("visible"));
  check_members(rows[0],
                R"({"scene": "builtin:50", "view": "front", "width": 26, "image": "a/b/front.png"})");
  CHECK(rows[1]["image"] == "a/b/orbit-00.png");
  CHECK(rows[1]["ms"]["total"] > 0);
  const json counted =
      json::parse(run_noting(place, "render builtin:50 --scale 0.02 --stats --json -").out)["rows"][0];
  CHECK(counted["gaussians"] == 50);
  for (const char* member : {"visible", "intersections", "contributing_pairs"}) CHECK(counted[member] > 0);
  CHECK(counted["pixels_stopped"].is_number());
}

TEST_CASE("cli json: results are not written over what is read") {
  const TemporaryFolder place;
  place.write("capture/cameras.json", cameras_json({"a.jpg"}));
  write_scene(place / "capture/scene.ply", swiftgs::make_builtin_scene(10));
  for (const std::string command : {"info capture/scene.ply", "render capture/scene.ply", "check capture"})
    fails(place, command + " --json ./capture/scene.ply", {"expected another file than that of SCENE"});
  fails(place, "check capture --json capture/cameras.json", {"expected another file than that of --cameras"});
  CHECK(swiftgs::load_scene(place / "capture/scene.ply").size() == 10);
}

}  // namespace swiftgs::test::json_test
