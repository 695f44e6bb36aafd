// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <set>
#include <sstream>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/swiftgs.hpp>

#include "cli/cameras.hpp"
#include "cli/json_in.hpp"
#include "cli/pictures.hpp"

namespace swiftgs::test::commands_test {

namespace fs = std::filesystem;

TEST_CASE("cli: info tells format and count and percentiles") {
  const TemporaryFolder place;
  const std::string text = run(place, "info builtin:2000").out;
  check_holds(text, {"Gaussians       2000\n", "SH degree       3\n", "dropped         0 of 2000", "50%",
                     "opacity", "longest scale", "format          built in\n"});
  CHECK(!contains(text, "bytes  "));

  swiftgs::Scene scene = swiftgs::make_builtin_scene(100);
  std::fill(scene.sh_rest.begin(), scene.sh_rest.end(), 0.0f);
  write_scene(place / "scene.ply", scene);
  check_holds(run(place, "info scene.ply").out,
              {"INRIA PLY", "Gaussians       100\n",
               "bytes           " + std::to_string(fs::file_size(place / "scene.ply")) + "\n",
               "read in         ", "bands above 0 are zero"});
}

TEST_CASE("cli: list has every combination of policies and whether it runs here") {
  const TemporaryFolder place;
  std::istringstream lines(run(place, "list").out);
  std::size_t serial = 0, all = 0;
  for (std::string line; std::getline(lines, line); ++all) {
    CAPTURE(line);
    std::istringstream words(line);
    std::string name;
    words >> name;
    CHECK(std::count(name.begin(), name.end(), '/') == 3);
    const bool runs = line.ends_with("  runs here");
    CHECK((runs || line.ends_with("  cannot run here")));
    serial += runs && name.starts_with("serial/");
  }
  const std::size_t each = swiftgs::AllSorts::size * swiftgs::AllRasters::size * swiftgs::AllBounds::size;
  CHECK(serial == each);
  CHECK(all % each == 0);
}

TEST_CASE("cli: render writes an image and says where it is and how long it took") {
  const TemporaryFolder place;
  check_holds(run(place, "render builtin:2000 --scale 0.1").out,
              {"renders/front.png  128x72  ", " ms (project "});
  const swiftgs::Image image = swiftgs::read_image(place / "renders/front.png");
  CHECK(image.width == 128);
  CHECK(image.height == 72);
  double sum = 0;
  for (float value : image.pixels) sum += double(value);
  CHECK(sum / double(image.pixels.size()) > 0.25);
}

TEST_CASE("cli: render writes the planes that it is asked for to an EXR") {
  const TemporaryFolder place;
  const std::string render =
      "render builtin:2000 --scale 0.05 --renderer serial/early/per-pixel/ellipse --format exr --out ";
  std::string all;  // in another order than the table's
  std::vector<std::string> channels;
  swiftgs::for_each_plane(
      [&](std::size_t, const swiftgs::PlaneRow& row) {
        if (row.name == std::string("colour") || row.name == std::string("features")) return;
        all = row.name + (all.empty() ? "" : "," + all);
        for (int c = 0; c < row.channels; ++c) channels.emplace_back(row.channel_names[c]);
      },
      swiftgs::plane_table);
  const Outcome outcome = swiftgs::test::swiftgs(place, render + "all --planes " + all);
  if (contains(outcome.err, "this build is without OpenEXR")) return;
  CHECK(outcome.code == 0);
  run(place, render + "few --planes median_depth,id");
  run(place, render + "none");
  const auto has = [&](const char* folder, const std::string& channel) {
    return contains(content_of(place / folder / "front.exr"), '\0' + channel + '\0');
  };
  for (const std::string& channel : channels) {
    CAPTURE(channel);
    CHECK(has("all", channel));
    const bool of_few = channel == "depth.median" || channel == "id.gaussian";
    CHECK(has("few", channel) == of_few);
    CHECK_FALSE(has("none", channel));
  }
}

TEST_CASE("cli: render --stats prints what a frame had to do") {
  const TemporaryFolder place;
  const std::string text = run(place, "render builtin:2000 --scale 0.1 --stats").out;
  check_holds(text, {"Gaussians  ", "visible  ", "intersections  ", "intersections a visible Gaussian  ",
                     "contributing pairs  ", "pixels stopped early  "});
  CHECK_FALSE(contains(text, "contributing pairs                0\n"));
}

TEST_CASE("cli: render --views chooses numbers or every so many or all or leaves some out") {
  const TemporaryFolder place;
  const auto drawn = [&](const std::string& views) {
    return names_drawn(place, "builtin:10 --scale 0.02 --views " + views);
  };
  using Names = std::set<std::string>;
  CHECK(drawn("1,3") == Names{"orbit-00.png", "orbit-02.png"});
  CHECK(drawn("3-5,8").size() == 4);
  CHECK(drawn("every:12") == Names{"front.png", "orbit-11.png", "orbit-23.png"});
  CHECK(drawn("all").size() == 25);
  const Names some = drawn("except:2");
  CHECK(some.size() == 12);
  CHECK(some.count("orbit-00.png") == 1);
  CHECK(some.count("front.png") + some.count("orbit-01.png") == 0);
}

TEST_CASE("cli: images of cameras with the same name do not share a file") {
  const TemporaryFolder place;
  place.write("cameras.json", cameras_json({"a/same", "a/same"}));
  const std::string render = "builtin:100 --cameras cameras.json";
  CHECK(names_drawn(place, render) == std::set<std::string>{"a_same.png", "a_same-1.png"});
  CHECK(names_drawn(place, render + " --views 0,0,0").size() == 3);
}

TEST_CASE("cli: render draws several views in a frame as it draws each alone") {
  const TemporaryFolder place;
  const std::string frame = "render builtin:2000 --scale 0.05 --views 0-6 --format pfm ";
  run(place, frame + "--out alone --json alone.json");
  check_holds(run(place, frame + "--out batch --batch 3 --stats --json batch.json").out,
              {"7 images with ", " ms a view\n"});
  const json alone = json_in(place / "alone.json")["rows"], rows = json_in(place / "batch.json")["rows"];
  REQUIRE(rows.size() == 7);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    CHECK(alone[i]["batch"] == 1);
    CHECK(rows[i]["batch"] == (i < 6 ? 3 : 1));
    CHECK(rows[i]["view"] == alone[i]["view"]);
    CHECK(rows[i]["ms"] == rows[i / 3 * 3]["ms"]);
    CHECK(rows[i]["ms"]["total"] > 0);
    CHECK(rows[i]["visible"] > 0);
    CHECK(content_of(place / rows[i]["image"].get<std::string>()) ==
          content_of(place / alone[i]["image"].get<std::string>()));
  }
  CHECK(names_drawn(place, "builtin:100 --scale 0.02 --views 0-2 --batch 50").size() == 3);
}

TEST_CASE("cli: a scene of no Gaussians is background") {
  const TemporaryFolder place;
  write_scene(place / "scene.ply", swiftgs::Scene());
  CHECK(contains(run(place, "info scene.ply").out, "Gaussians       0\n"));
  const std::vector<float> pixels = drawn(place, "scene.ply --scale 0.05 --background 0.5,0.25,1").pixels;
  CHECK(std::vector(pixels.begin(), pixels.begin() + 3) == std::vector{0.5f, 0.25f, 1.0f});
}

TEST_CASE("cli: conventions and renderers change the image as little as they should, by compare") {
  const TemporaryFolder place;
  const std::string frame = "render builtin:2000 --scale 0.1 --format pfm ";
  run(place, frame + "--out a --renderer serial/standard/per-pixel/ellipse");
  run(place, frame + "--out b --renderer serial/early/axis-shared-float-split/opacity-box");
  run(place, frame + "--out c --renderer serial/standard/per-pixel/ellipse --conventions inria");
  const auto compared = [&](const std::string& files) {
    return json::parse(run(place, "compare " + files).out);
  };
  CHECK(compared("a/front.pfm b/front.pfm")["max_abs"] < 0.005);
  CHECK(compared("a/front.pfm c/front.pfm")["max_abs"] > 0);
  const json same = compared("a/front.pfm a/front.pfm");
  CHECK(same.size() == 4);
  check_members(same, R"({"notes": [], "max_abs": 0, "psnr_db": null})");
  CHECK(same["ssim"].get<double>() == doctest::Approx(1));
}

TEST_CASE("cli: check writes one object a renderer and view") {
  const TemporaryFolder place;
  const Outcome outcome = run(place,
                              "check builtin:1000 --scale 0.05 --views 0,5 --repeats 1 --json results.json "
                              "--renderers 'serial/standard/per-pixel/*'");
  const json results = json_in(place / "results.json")["rows"];
  constexpr std::size_t renderers = swiftgs::AllBounds::size;
  CHECK(results.size() == 2 * renderers);
  // A header, and for each renderer two views and their mean.
  CHECK(std::size_t(lines_in(outcome.out)) == 1 + 3 * renderers);
  for (const json& result : results) {
    check_members(result, R"({"scene": "builtin:1000", "width": 64, "height": 36})");
    CHECK((result["view"] == "front" || result["view"] == "orbit-04"));
    CHECK(result["ms"]["total"] > 0);
    if (contains(result["renderer"], "three-sigma-square")) continue;
    CHECK(result["psnr_db"] >= 125);
    CHECK(result["max_abs"] <= 1.0 / 255);
  }
}

TEST_CASE("cli: help explains every command and gives examples") {
  const TemporaryFolder place;
  const std::string help = run(place, "--help").out;
  CHECK(run(place, "help").out == help);
  CHECK(run(place, "help render").out == run(place, "render --help").out);
  CHECK(run(place, "render -h").out == run(place, "render --help").out);
  for (const std::string command : {"info", "list", "render", "compare", "check", "prune"}) {
    CHECK(contains(help, "  " + command + "  "));
    const std::string more = run(place, command + " --help").out;
    CHECK(contains(more, "Usage: swiftgs " + command));
    if (command != "list") CHECK(contains(more, "\n  swiftgs " + command));
  }
}

}  // namespace swiftgs::test::commands_test
