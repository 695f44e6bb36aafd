// SPDX-License-Identifier: Apache-2.0
#include <set>
#include <sstream>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/io/image.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/swiftgs.hpp>

#include "cli/command.hpp"
#include "cli/json_in.hpp"
#include "support/ply_numbers.hpp"

using nlohmann::json;
using swiftgs::test::contains;
using swiftgs::test::content_of;
using swiftgs::test::json_in;
using swiftgs::test::Outcome;
using swiftgs::test::run;
using swiftgs::test::run_noting;
using swiftgs::test::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

/// Names of the files in a folder.
std::set<std::string> files_in(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.insert(entry.path().filename().string());
  return names;
}

}  // namespace

TEST_CASE("cli: info tells format and count and percentiles") {
  const TemporaryFolder place;
  const std::string text = run(place, "info builtin:2000").out;
  for (const char* part : {"Gaussians       2000\n", "SH degree       3\n", "dropped         0 of 2000",
                           "50%", "opacity", "longest scale", "format          built in\n"})
    CHECK(contains(text, part));

  swiftgs::Scene scene = swiftgs::make_builtin_scene(100);
  std::fill(scene.sh_rest.begin(), scene.sh_rest.end(), 0.0f);
  write_scene(place / "scene.ply", scene);
  const std::string of_file = run(place, "info scene.ply").out;
  CHECK(contains(of_file, "INRIA PLY"));
  CHECK(contains(of_file, "Gaussians       100\n"));
  CHECK(contains(of_file, "bytes           " + std::to_string(fs::file_size(place / "scene.ply")) + "\n"));
  CHECK(contains(of_file, "read in         "));
  CHECK(!contains(text, "bytes  "));
  CHECK(contains(of_file, "bands above 0 are zero"));
}

TEST_CASE("cli: info counts what was dropped") {
  const TemporaryFolder place;
  write_scene(place / "scene.ply", swiftgs::make_builtin_scene(10));
  constexpr std::size_t x = 0;
  swiftgs::test::set_ply_number(place / "scene.ply", 10, 3, x, std::numeric_limits<float>::quiet_NaN());
  const std::string text = run(place, "info scene.ply").out;
  CHECK(contains(text, "Gaussians       9\n"));
  CHECK(contains(text, "dropped         1 of 10"));
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
  const std::string text = run(place, "render builtin:2000 --scale 0.1").out;
  CHECK(contains(text, "renders/front.png  128x72  "));
  CHECK(contains(text, " ms (project "));
  const swiftgs::Image image = swiftgs::read_image(place / "renders/front.png");
  CHECK(image.width == 128);
  CHECK(image.height == 72);
  double sum = 0;
  for (float value : image.pixels) sum += double(value);
  CHECK(sum / double(image.pixels.size()) > 0.25);
}

TEST_CASE("cli: render --stats prints what a frame had to do") {
  const TemporaryFolder place;
  const std::string text = run(place, "render builtin:2000 --scale 0.1 --stats").out;
  for (const char* part :
       {"Gaussians  ", "visible  ", "intersections  ", "intersections a visible Gaussian  ",
        "contributing pairs  ", "pixels stopped early  ", "raster while counting, ms  ", "balanced, ms  "})
    CHECK(contains(text, part));
  CHECK_FALSE(contains(text, "contributing pairs               0\n"));
}

TEST_CASE("cli: render --views chooses numbers or every so many or all") {
  const TemporaryFolder place;
  run(place, "render builtin:100 --scale 0.02 --out list --views 1,3");
  CHECK(files_in(place / "list") == std::set<std::string>{"orbit-00.png", "orbit-02.png"});
  run(place, "render builtin:100 --scale 0.02 --out every --views every:12");
  CHECK(files_in(place / "every") == std::set<std::string>{"front.png", "orbit-11.png", "orbit-23.png"});
  run(place, "render builtin:100 --scale 0.02 --out all --views all");
  CHECK(files_in(place / "all").size() == 25);
}

TEST_CASE("cli: images of cameras with the same name do not share a file") {
  const TemporaryFolder place;
  const json camera = {{"id", 0},
                       {"img_name", "a/same"},
                       {"width", 32},
                       {"height", 16},
                       {"fx", 30.0},
                       {"fy", 30.0},
                       {"position", {0, -1, -4}},
                       {"rotation", {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}};
  place.write("cameras.json", json::array({camera, camera}).dump());
  run(place, "render builtin:100 --cameras cameras.json --out out");
  CHECK(files_in(place / "out") == std::set<std::string>{"a_same.png", "a_same-1.png"});
  run(place, "render builtin:100 --cameras cameras.json --out again --views 0,0,0");
  CHECK(files_in(place / "again").size() == 3);
}

TEST_CASE("cli: render takes ranges of views") {
  const TemporaryFolder place;
  run(place, "render builtin:10 --scale 0.02 --views 3-5,8");
  CHECK(files_in(place / "renders").size() == 4);
}

TEST_CASE("cli: render draws several views in a frame as it draws each alone") {
  const TemporaryFolder place;
  const std::string frame = "render builtin:2000 --scale 0.05 --views 0-6 --format pfm ";
  run(place, frame + "--out alone --json alone.json");
  const std::string text = run(place, frame + "--out batch --batch 3 --stats --json batch.json").out;
  CHECK(contains(text, "7 images with "));
  CHECK(contains(text, " ms a view\n"));
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
  run(place, "render builtin:100 --scale 0.02 --views 0-2 --batch 50 --out all");
  CHECK(files_in(place / "all").size() == 3);
}

TEST_CASE("cli: a batch of no views or of more than a frame has is refused") {
  const TemporaryFolder place;
  for (const std::string command : {"render", "bench"})
    for (const std::string batch : {"0", "-3", "65537"}) {
      const Outcome outcome = swiftgs::test::swiftgs(place, command + " builtin:50 --batch=" + batch);
      CHECK(outcome.code == 1);
      CHECK(outcome.err == "swiftgs: --batch " + batch + ": expected 1 to 65536\n");
    }
}

TEST_CASE("cli: render shows the background where nothing else is") {
  const TemporaryFolder place;
  run(place, "render builtin:1 --scale 0.1 --format pfm --background 0.5,0.25,1");
  const swiftgs::Image image = swiftgs::read_image(place / "renders/front.pfm");
  CHECK(image.pixels[0] == 0.5f);
  CHECK(image.pixels[1] == 0.25f);
  CHECK(image.pixels[2] == 1.0f);
}

TEST_CASE("cli: a scene without cameras is seen from where it fills the image") {
  const TemporaryFolder place;
  write_scene(place / "scene.ply", swiftgs::make_builtin_scene(5000));
  const auto pixels_before = [&](const std::string& background) {
    run(place, "render scene.ply --scale 0.1 --format pfm --background " + background);
    return swiftgs::read_image(place / "renders/view.pfm").pixels;
  };
  const std::vector<float> dark = pixels_before("0,0,0"), light = pixels_before("1,1,1");
  std::size_t filled = 0;
  for (std::size_t i = 0; i < dark.size(); ++i) filled += light[i] - dark[i] < 0.5f;
  CHECK(double(filled) > 0.8 * double(dark.size()));
}

TEST_CASE("cli: a scene of no Gaussians is background") {
  const TemporaryFolder place;
  write_scene(place / "scene.ply", swiftgs::Scene());
  CHECK(contains(run(place, "info scene.ply").out, "Gaussians       0\n"));
  run(place, "render scene.ply --scale 0.05 --format pfm --background 0.5,0.5,0.5");
  const swiftgs::Image image = swiftgs::read_image(place / "renders/view.pfm");
  CHECK(std::all_of(image.pixels.begin(), image.pixels.end(), [](float v) { return v == 0.5f; }));
}

TEST_CASE("cli: conventions and renderers change the image as little as they should") {
  const TemporaryFolder place;
  const std::string frame = "render builtin:2000 --scale 0.1 --format pfm ";
  run(place, frame + "--out a --renderer serial/standard/per-pixel/ellipse");
  run(place, frame + "--out b --renderer serial/early/axis-shared-float-split/opacity-box");
  run(place, frame + "--out c --renderer serial/standard/per-pixel/ellipse --conventions inria");
  const json same = json::parse(run(place, "compare a/front.pfm b/front.pfm").out);
  CHECK(same["max_abs"] < 0.005);
  const json other = json::parse(run(place, "compare a/front.pfm c/front.pfm").out);
  CHECK(other["max_abs"] > 0);
}

TEST_CASE("cli: an image compared with itself has no difference") {
  const TemporaryFolder place;
  run(place, "render builtin:500 --scale 0.05");
  const Outcome outcome = run(place, "compare renders/front.png renders/front.png");
  const json result = json::parse(outcome.out);
  CHECK(result.size() == 4);
  CHECK(result["notes"] == json::array());
  CHECK(result["max_abs"] == 0);
  CHECK(result["ssim"].get<double>() == doctest::Approx(1));
  CHECK(result["psnr_db"].is_null());
}

TEST_CASE("cli: check writes one object a renderer and view with exactly these members") {
  const TemporaryFolder place;
  const Outcome outcome = run(place,
                              "check builtin:1000 --scale 0.05 --views 0,5 --repeats 1 --json results.json "
                              "--renderers 'serial/standard/per-pixel/*'");
  const json results = json_in(place / "results.json")["rows"];
  constexpr std::size_t renderers = swiftgs::AllBounds::size;
  CHECK(results.size() == 2 * renderers);
  // A header, and for each renderer two views and their mean.
  CHECK(std::size_t(swiftgs::test::lines_in(outcome.out)) == 1 + 3 * renderers);
  for (const json& result : results) {
    std::set<std::string> members, stages;
    for (const auto& item : result.items()) members.insert(item.key());
    for (const auto& item : result["ms"].items()) stages.insert(item.key());
    CHECK(members ==
          std::set<std::string>{"renderer", "scene", "view", "width", "height", "ms", "psnr_db", "max_abs"});
    CHECK(stages == std::set<std::string>{"project", "sort", "raster", "total"});
    CHECK(result["scene"] == "builtin:1000");
    CHECK((result["view"] == "front" || result["view"] == "orbit-04"));
    CHECK(result["width"] == 64);
    CHECK(result["height"] == 36);
    CHECK(result["ms"]["total"] > 0);
    if (contains(result["renderer"], "three-sigma-square")) continue;
    CHECK(result["psnr_db"] >= 125);
    CHECK(result["max_abs"] <= 1.0 / 255);
  }
}

TEST_CASE("cli: check compares with the photographs that have the names of the views") {
  const TemporaryFolder place;
  run(place, "render builtin:1000 --scale 0.05 --out photos");
  const std::string err =
      run_noting(
          place,
          "check builtin:1000 --scale 0.05 --views 0,1 --repeats 1 --photos photos --json results.json "
          "--renderers serial/early/per-pixel/ellipse")
          .err;
  CHECK(err == "swiftgs: photos: 1 of 2 views have no photograph, such as orbit-00.\n");
  const json results = json_in(place / "results.json")["rows"];
  REQUIRE(results.size() == 2);
  // The photograph is this very frame in 8 bits.
  CHECK(results[0]["photo_psnr_db"] > 50);
  CHECK(results[1]["photo_psnr_db"].is_null());
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

TEST_CASE("cli: help names the files that are read") {
  const TemporaryFolder place;
  const std::string files =
      ".ply, .compressed.ply, .spz, .sog, meta.json, lod-meta.json, .glb, .gltf, .splat or .ksplat";
  for (const std::string command : {"", "info ", "render ", "check ", "convert ", "prune ", "calibrate "})
    CHECK(contains(run(place, command + "--help").out, files));
}
