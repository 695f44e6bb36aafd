// SPDX-License-Identifier: Apache-2.0
#include <limits>
#include <string>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/io/image.hpp>
#include <swiftgs/io/scene_file.hpp>

#include "cli/command.hpp"
#include "cli/json_in.hpp"
#include "io/png_encoder.hpp"
#include "support/ply_numbers.hpp"

using nlohmann::json;
using swiftgs::test::contains;
using swiftgs::test::content_of;
using swiftgs::test::json_in;
using swiftgs::test::lines_in;
using swiftgs::test::Outcome;
using swiftgs::test::TemporaryFolder;

namespace {

const std::string left_out = "scene.ply: Gaussians with a NaN or an infinity are left out: 1.";
const std::string not_read = "scene.ply: Elements other than Gaussians were not read: label.";
const std::string one = " --renderers serial/early/per-pixel/ellipse";

/// A folder with `scene.ply`, of which a reader has two things to note.
struct Place : TemporaryFolder {
  Place() {
    write_scene(*this / "scene.ply", swiftgs::make_builtin_scene(50));
    swiftgs::test::set_ply_number(*this / "scene.ply", 50, 7, 0, std::numeric_limits<float>::quiet_NaN());
    std::string content = content_of(*this / "scene.ply");
    content.insert(content.find("end_header"), "element label 1\nproperty uchar kind\n");
    write("scene.ply", content + "x");
  }
};

}  // namespace

TEST_CASE("cli notes: every command that reads a scene says them on standard error and in its results") {
  for (const std::string arguments :
       {"render scene.ply --scale 0.02", "check scene.ply --scale 0.02 --repeats 1",
        "bench scene.ply --scales 0.05 --min-frames 2 --max-frames 2",
        "prune scene.ply --keep 0.5 --score opacity-volume --out small.ply", "convert scene.ply b.ply"}) {
    CAPTURE(arguments);
    const Place place;
    const bool picks = arguments.starts_with("check") || arguments.starts_with("bench");
    const Outcome outcome = swiftgs::test::swiftgs(place, arguments + (picks ? one : "") + " --json b2.json");
    CAPTURE(outcome.err);
    CHECK(outcome.code == 0);
    CHECK(outcome.err == "swiftgs: " + not_read + "\nswiftgs: " + left_out + "\n");
    CHECK(json_in(place / "b2.json")["notes"] == json({not_read, left_out}));
  }
}

TEST_CASE("cli notes: every command that reads cameras says theirs before those of the scene") {
  const std::string of_cameras =
      "transforms.json: Keys that may change the picture were not read: rolling_shutter.";
  for (const std::string command : {"render", "check", "bench", "prune"}) {
    CAPTURE(command);
    const Place place;
    const json matrix = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 4}, {0, 0, 0, 1}};
    const json frame = {{"file_path", "a.png"}, {"transform_matrix", matrix}};
    const json file = {{"w", 16},
                       {"h", 12},
                       {"fl_x", 20},
                       {"rolling_shutter", {0, 0, 0.5}},
                       {"frames", json::array({frame, frame})}};
    place.write("transforms.json", file.dump());
    // A capture, so that `bench` finds the cameras too.
    std::string arguments = command + " . --json result.json";
    if (command == "prune") arguments += " --keep 0.5 --views 0 --out " + (place / "small.ply").string();
    if (command == "bench") arguments += " --min-frames 2 --max-frames 2" + one;
    if (command == "check") arguments += " --repeats 1" + one;
    const Outcome outcome = swiftgs::test::swiftgs(place, arguments);
    CAPTURE(outcome.err);
    CHECK(outcome.code == 0);
    CHECK(contains(outcome.err, of_cameras + "\n"));
    const json notes = json_in(place / "result.json")["notes"];
    REQUIRE(notes.size() == 3);
    CHECK(contains(notes[0].get<std::string>(), of_cameras));
  }
}

TEST_CASE("cli notes: info lists them in its table") {
  const Place place;
  const Outcome outcome = swiftgs::test::run(place, "info scene.ply");
  CHECK(contains(outcome.out, "note            " + left_out.substr(11) + "\n"));
  CHECK(contains(outcome.out, "note            " + not_read.substr(11) + "\n"));
  CHECK(contains(outcome.out, "dropped         1 of 50"));
  swiftgs::test::run(place, "info scene.ply --json info.json");
  CHECK(json_in(place / "info.json")["notes"] == json({not_read, left_out}));
}

TEST_CASE("cli notes: compare says that alpha is not compared") {
  const TemporaryFolder place;
  using namespace swiftgs::test;
  place.write("a.png", png({.colour = png_grey_alpha, .rows = std::string("\0\xff\0", 3)}));
  const Outcome outcome = swiftgs::test::swiftgs(place, "compare a.png a.png");
  CAPTURE(outcome.err);
  CHECK(outcome.code == 0);
  CHECK(contains(outcome.err, "swiftgs: a.png: Alpha is not compared.\n"));
  const std::string note = "a.png: Alpha is not compared.";
  CHECK(json::parse(outcome.out)["notes"] == json::array({note}));
}
