// SPDX-License-Identifier: Apache-2.0
#include <set>
#include <string>

#include <doctest/doctest.h>
#include <glm/common.hpp>
#include <nlohmann/json.hpp>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/edit/all.hpp>
#include <swiftgs/io/scene_file.hpp>

#include "cli/command.hpp"
#include "cli/json_in.hpp"

namespace swiftgs::test::convert_test {

namespace {

/// A folder with the built-in scene of 300 Gaussians in `a.ply`, as a file holds it.
struct Place : TemporaryFolder {
  Place() {
    write_scene(*this / "a.ply", swiftgs::make_builtin_scene(300));
    a = load_scene(*this / "a.ply");
  }
  Scene a;
};

/// What `a.ply` becomes with `options`.
Scene converted(const Place& place, const std::string& options) {
  run(place, "convert a.ply b.ply " + options);
  return load_scene(place / "b.ply");
}

/// Expects one line of error that holds `part`, and no file `b.ply`.
void fails(const Place& place, const std::string& arguments, const std::string& part) {
  swiftgs::test::fails(place, "convert " + arguments, {part});
  CHECK_FALSE(std::filesystem::exists(place / "b.ply"));
}

}  // namespace

TEST_CASE("cli convert: a scene without edits is written as it is") {
  const Place place;
  check_holds(run(place, "convert a.ply b.ply").out,
              {"\nread              300          0      3 ", "\nwritten           300          0      3 "});
  const Scene b = load_scene(place / "b.ply");
  CHECK(b.means == place.a.means);
  CHECK(b.sh_rest == place.a.sh_rest);
}

TEST_CASE("cli convert: several scenes become one, in their order") {
  const Place place;
  run(place, "convert a.ply builtin:50 a.ply b.ply");
  const Scene b = load_scene(place / "b.ply");
  CHECK(b.size() == 650);
  CHECK(b.means[0] == place.a.means[0]);
  CHECK(b.means[350] == place.a.means[0]);
  CHECK(b.means[649] == place.a.means[299]);
}

TEST_CASE("cli convert: edits are those of the library") {
  const Place place;
  CHECK(converted(place, "--degree 1").sh_rest == with_degree(place.a, 1).sh_rest);
  CHECK(converted(place, "--degree 3").sh_degree == 3);

  Scene moved = place.a;
  swiftgs::Similarity by;
  by.scale = 2;
  transform(moved, by);
  by.scale = 1, by.translation = {1, -2, 3.5};
  transform(moved, by);
  CHECK(converted(place, "--transform scale:2 --transform move:1,-2,3.5").means == moved.means);
  CHECK(converted(place, "--transform matrix:2,0,0,1,0,2,0,-2,0,0,2,3.5").means == moved.means);
  CHECK(converted(place, "--transform move:1,-2,3.5 --transform scale:2").means != moved.means);

  Scene wide = place.a;
  stretch(wide, {.linear = {2, 0, 0, 0, 1, 0, 0, 0, 0.5}}, {0, 0, 0});
  CHECK(converted(place, "--transform scale:2,1,0.5").means == wide.means);
  CHECK(converted(place, "--transform matrix:2,0,0,0,0,1,0,0,0,0,0.5,0").means == wide.means);
  // A quarter turn about z: x becomes y.
  const Scene turned = converted(place, "--transform rotate:0,0,2,90");
  CHECK(turned.means[37].y == doctest::Approx(double(place.a.means[37].x)).epsilon(1e-6));

  CHECK(converted(place, "--crop sphere:0,0,0,1.5").means ==
        crop(place.a, swiftgs::Sphere{{0, 0, 0}, 1.5}).means);
  CHECK(converted(place, "--crop box:-1,-1,-1,1,1,1 --crop half-space:1,0,0,0").means ==
        crop(crop(place.a, swiftgs::Box{{-1, -1, -1}, {1, 1, 1}}), swiftgs::HalfSpace{{1, 0, 0}, 0}).means);
  CHECK(converted(place, "--order").means == order_spatially(place.a).means);
  CHECK(converted(place, "--keep 0.1").size() == 30);
}

TEST_CASE("cli convert: the text and the results tell what was read, left out and written") {
  const Place place;
  check_holds(run(place, "convert a.ply b.ply --degree 1 --crop half-space:1,0,0,0 --json b.json").out,
              {"\nedited ", " --crop half-space:1,0,0,0\n"});
  const json result = json_in(place / "b.json");
  CHECK(members_of(result) == std::set<std::string>{"format", "version", "machine", "command", "notes",
                                                    "inputs", "steps", "output"});
  const std::size_t left = load_scene(place / "b.ply").size();
  CHECK(left > 0);
  CHECK(left < 300);
  CHECK(result["inputs"].size() == 1);
  CHECK(result["inputs"][0]["gaussians"] == 300);
  CHECK(result["inputs"][0]["bytes"] == std::filesystem::file_size(place / "a.ply"));
  CHECK(result["steps"].size() == 2);
  check_members(result["steps"][0], R"({"what": "--degree 1", "gaussians": 300})");
  CHECK(result["steps"][1]["what"] == "--crop half-space:1,0,0,0");
  CHECK(result["steps"][1]["gaussians"] == left);
  CHECK(result["output"]["gaussians"] == left);
  CHECK(result["output"]["sh_degree"] == 1);
  CHECK(result["output"]["bytes"] == std::filesystem::file_size(place / "b.ply"));
}

TEST_CASE("cli convert: what a format leaves out is told of the file that is written") {
  const Place place;
  Scene scene = place.a;
  scene.model.antialiased = true;
  write_scene(place / "b.ply", scene);
  const Outcome outcome = run_noting(place, "convert b.ply b.splat --json b.json");
  CHECK(contains(outcome.err, "swiftgs: b.splat: "));
  check_holds(outcome.out,
              {"\nread              300          0      3 ", "\nwritten           300          0      0 "});
  const json result = json_in(place / "b.json");
  check_members(result["inputs"][0], R"({"sh_degree": 3, "model": "antialiased=yes"})");
  check_members(result["output"], R"({"sh_degree": 0, "model": ""})");
  CHECK(result["notes"].size() >= 2);
}

TEST_CASE("cli convert: Gaussians that fill chunks beside strays are no Gaussians of the scene") {
  const TemporaryFolder place;
  swiftgs::Scene scene = swiftgs::make_builtin_scene(1000);
  scene.means[5].x = 1e6f;
  write_scene(place / "a.ply", scene);
  const Outcome outcome = run_noting(place, "convert a.ply b.compressed.ply --json b.json");
  check_holds(outcome.out, {"\nwritten          1000          0 "});
  CHECK(contains(outcome.err, "chunks of their own: 25.\n"));
  check_members(json_in(place / "b.json")["output"], R"({"stored": 1000, "gaussians": 1000})");
  CHECK(swiftgs::load_scene(place / "b.compressed.ply").size() == 1025);
}

TEST_CASE("cli convert: the largest losses of what was written are told") {
  const Place place;
  const Outcome exact = run(place, "convert a.ply b.ply --json b.json");
  CHECK_FALSE(contains(exact.out, "rounded"));
  check_members(
      json_in(place / "b.json")["output"]["losses"],
      R"({"position": 0, "gaussian": null, "displaced": 0, "scale_factor": 1, "opacity": 0, "colour": 0})");
  check_holds(run_noting(place, "convert a.ply b.spz --json b.json").out,
              {"\nrounded    at most: positions by ", " units, scales by a factor of ", ", opacities by 0.00",
               ", colours by 0.00"});
  CHECK(json_in(place / "b.json")["output"]["losses"]["position"] > 0);
  CHECK_FALSE(json_in(place / "b.json")["inputs"][0].contains("losses"));
}

TEST_CASE("cli convert: --level chooses the level of detail of a streamed SOG") {
  const Place place;
  write_scene(place / "fine.sog", place.a);
  write_scene(place / "coarse.sog", swiftgs::make_builtin_scene(50));
  place.write("lod-meta.json", R"({"lodLevels":2,"filenames":["fine.sog","coarse.sog"],"tree":{"lods":{
      "0":{"file":0,"offset":0,"count":300},"1":{"file":1,"offset":0,"count":50}}}})");
  run_noting(place, "convert lod-meta.json b.ply");
  CHECK(load_scene(place / "b.ply").means == load_scene(place / "fine.sog").means);
  run_noting(place, "convert lod-meta.json b.ply --level 1 --json b.json");
  CHECK(load_scene(place / "b.ply").means == load_scene(place / "coarse.sog").means);
  CHECK(json_in(place / "b.json")["inputs"][0]["file_format"] == "streamed SOG, level 1 of 2");
  std::filesystem::remove(place / "b.ply");
  fails(place, "lod-meta.json b.ply --level 2", "expected level 2 of detail, found 2 levels, 0 to 1");
}

TEST_CASE("cli convert: scenes of different models are joined only where an option says one for all") {
  const Place place;
  Scene other = place.a;
  other.model.antialiased = true;
  write_scene(place / "other.ply", other);
  fails(place, "a.ply other.ply b.ply",
        "other.ply: expected the rendering model of a.ply, the usual one, found antialiased=yes");
  for (const std::string said : {"yes", "no"}) {
    run(place, "convert a.ply other.ply b.ply --model antialiased=" + said);
    const Scene joined = load_scene(place / "b.ply");
    CHECK(joined.size() == 600);
    CHECK(joined.model.antialiased == (said == "yes"));
  }
}

TEST_CASE("cli convert: an .spz is written with the axes that --spz-write-frame names") {
  const Place place;
  run_noting(place, "convert a.ply usual.spz");
  run_noting(place, "convert a.ply raw.spz --spz-write-frame raw");
  const auto means = [&](const std::string& name, swiftgs::SpzFrame frame) {
    return swiftgs::read_scene(place / name, {.spz_frame = frame}).scene.means;
  };
  using swiftgs::SpzFrame;
  CHECK(means("raw.spz", SpzFrame::specified) == means("usual.spz", SpzFrame::specified));
  CHECK(means("raw.spz", SpzFrame::raw) == means("usual.spz", SpzFrame::specified));
  CHECK(means("usual.spz", SpzFrame::raw) != means("usual.spz", SpzFrame::specified));
}

TEST_CASE("cli convert: a pipe takes the scene alone, in the format that --format names") {
  const Place place;
  run(place, "convert a.ply b.ply");
  for (const std::string to : {"", " | cat"}) {
    const bool same =
        run(place, "convert a.ply /dev/stdout --format ply" + to).out == content_of(place / "b.ply");
    CHECK(same);
  }
}

TEST_CASE("cli convert: bad arguments are one line, and nothing is written") {
  const Place place;
  fails(place, "a.ply", "expected one or more scenes to read and a file to write");
  fails(place, "a.ply -", "-: expected a file to write, such as /dev/stdout");
  fails(place, "a.ply b.ply --model antialiased=maybe",
        "model: 'antialiased=maybe' is not known; expected antialiased=yes or no");
  fails(place, "a.ply b.ply --spz-write-frame up", "--spz-write-frame 'up': expected specified, rub");
  fails(place, "a.ply b.xyz", "b.xyz: expected a scene's name that ends in one of");
  fails(place, "a.ply b.ply --format xyz", ".xyz: expected a scene's name");
  fails(place, "missing.ply b.ply", "missing.ply: No such file");
  fails(place, "a.ply missing/b.ply", "missing");
  fails(place, "a.ply b.ply --degree 4", "--degree 4: expected 0 to 3");
  fails(place, "a.ply b.ply --keep 0", "--keep 0: expected a part of the Gaussians");
  fails(place, "a.ply b.ply --spz-version 2", "--spz-version 2: expected 3 or 4");
  fails(place, "a.ply b.ply --crop cube:1", "--crop 'cube:1': expected box:");
  fails(place, "a.ply b.ply --crop box:1,1,1,0,0,x", "--crop 'box:1,1,1,0,0,x': expected box:");
  fails(place, "a.ply b.ply --crop box:1,1,1,0,0,0", "expected a box whose first corner is the lower one");
  fails(place, "a.ply b.ply --transform scale:-1", "--transform 'scale:-1': expected a finite scale above 0");
  fails(place, "a.ply b.ply --transform rotate:0,0,0,90", "expected an axis other than 0,0,0");
  fails(place, "a.ply b.ply --transform scale:1,0,1",
        "--transform 'scale:1,0,1': expected a finite scale above 0");
  fails(place, "a.ply b.ply --transform scale:1,2", "--transform 'scale:1,2': expected scale:S, scale:X,Y,Z");
  fails(place, "a.ply b.ply --transform matrix:-1,0,0,0,0,1,0,0,0,0,1,0",
        "--transform 'matrix:-1,0,0,0,0,1,0,0,0,0,1,0': expected a matrix that does not mirror");
  fails(place, "a.ply b.ply --transform matrix:1,1,0,0,1,1,0,0,0,0,1,0",
        "expected a matrix that does not flatten");
  fails(place, "a.ply a.ply", "expected another file than that of FILE");
  CHECK(content_of(place / "a.ply").size() > 1000);
}

}  // namespace swiftgs::test::convert_test
