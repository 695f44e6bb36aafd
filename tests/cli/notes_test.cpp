// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>
#include <string>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/io/scene_file.hpp>

#include "cli/command.hpp"
#include "cli/json_in.hpp"
#include "io/png_encoder.hpp"
#include "support/ply_numbers.hpp"

namespace swiftgs::test::notes_test {

namespace {

const std::string left_out = "scene.ply: Gaussians with a NaN or an infinity are left out: 1.";
const std::string no_rotation = "scene.ply: Gaussians whose quaternion is no rotation are left out: 1.";
const std::string not_read = "scene.ply: Elements other than Gaussians were not read: label.";
const std::string one = " --renderers serial/early/per-pixel/ellipse";

/// A folder with `scene.ply`, of which a reader has three things to note.
struct Place : TemporaryFolder {
  Place() {
    write_scene(*this / "scene.ply", swiftgs::make_builtin_scene(50));
    set_ply_number(*this / "scene.ply", 50, 7, 0, std::numeric_limits<float>::quiet_NaN());
    std::string content = content_of(*this / "scene.ply");
    std::fill(content.end() - 4 * sizeof(float), content.end(), '\0');  // the last quaternion
    content.insert(content.find("end_header"), "element label 1\nproperty uchar kind\n");
    write("scene.ply", content + "x");
  }
};

}  // namespace

TEST_CASE("cli notes: every command that reads a scene says them on standard error and in its results") {
  for (const std::string& arguments :
       {std::string("render scene.ply --scale 0.02"), "check scene.ply --scale 0.02 --repeats 1" + one,
        "bench scene.ply --scales 0.05 --min-frames 2 --max-frames 2" + one,
        std::string("prune scene.ply --keep 0.5 --score opacity-volume --out small.ply"),
        std::string("convert scene.ply b.ply")}) {
    CAPTURE(arguments);
    const Place place;
    CHECK(run_noting(place, arguments + " --json b2.json").err ==
          "swiftgs: " + not_read + "\nswiftgs: " + left_out + "\nswiftgs: " + no_rotation + "\n");
    CHECK(json_in(place / "b2.json")["notes"] == json({not_read, left_out, no_rotation}));
  }
}

TEST_CASE("cli notes: every command that reads cameras says theirs before those of the scene") {
  const std::string of_cameras =
      "transforms.json: Keys that may change the picture were not read: rolling_shutter.";
  // A capture, so that `bench` finds the cameras too.
  for (const std::string& arguments :
       {std::string("render ."), "check . --repeats 1" + one, "bench . --min-frames 2 --max-frames 2" + one,
        std::string("prune . --keep 0.5 --views 0 --out small.ply")}) {
    CAPTURE(arguments);
    const Place place;
    const json matrix = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 4}, {0, 0, 0, 1}};
    const json frame = {{"file_path", "a.png"}, {"transform_matrix", matrix}};
    const json file = {{"w", 16},
                       {"h", 12},
                       {"fl_x", 20},
                       {"rolling_shutter", {0, 0, 0.5}},
                       {"frames", json::array({frame, frame})}};
    place.write("transforms.json", file.dump());
    CHECK(contains(run_noting(place, arguments + " --json result.json").err, of_cameras + "\n"));
    const json notes = json_in(place / "result.json")["notes"];
    REQUIRE(notes.size() == 4);
    CHECK(contains(notes[0].get<std::string>(), of_cameras));
  }
}

TEST_CASE("cli notes: info lists them in its table") {
  const Place place;
  check_holds(
      run(place, "info scene.ply").out,
      {"note            " + left_out.substr(11) + "\n", "note            " + no_rotation.substr(11) + "\n",
       "note            " + not_read.substr(11) + "\n", "dropped         2 of 50"});
  run(place, "info scene.ply --json info.json");
  CHECK(json_in(place / "info.json")["notes"] == json({not_read, left_out, no_rotation}));
}

TEST_CASE("cli notes: compare says that alpha is not compared") {
  const TemporaryFolder place;
  place.write("a.png", png({.colour = png_grey_alpha, .rows = std::string("\0\xff\0", 3)}));
  const Outcome outcome = run_noting(place, "compare a.png a.png");
  const std::string note = "a.png: Alpha is not compared.";
  CHECK(contains(outcome.err, "swiftgs: " + note + "\n"));
  CHECK(json::parse(outcome.out)["notes"] == json::array({note}));
}

}  // namespace swiftgs::test::notes_test
