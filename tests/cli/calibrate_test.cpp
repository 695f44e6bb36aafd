// SPDX-License-Identifier: Apache-2.0
#include <set>
#include <string>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include <swiftgs/bounds/all.hpp>
#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/io/sort_calibrations.hpp>

#include "cli/command.hpp"
#include "cli/json_in.hpp"

using nlohmann::json;
using swiftgs::test::contains;
using swiftgs::test::content_of;
using swiftgs::test::json_in;
using swiftgs::test::lines_in;
using swiftgs::test::Outcome;
using swiftgs::test::run;
using swiftgs::test::TemporaryFolder;

namespace {

const std::string small = " --scale 0.05";
const std::string adaptive = " --format pfm --renderer serial/adaptive/per-pixel/ellipse";

/// Runs the tool and expects success all the same, and one line on standard error that holds all `parts`.
void run_with_notice(const TemporaryFolder& place, const std::string& arguments,
                     std::initializer_list<std::string> parts) {
  const Outcome outcome = swiftgs::test::swiftgs(place, arguments);
  CAPTURE(arguments);
  CAPTURE(outcome.err);
  CHECK(outcome.code == 0);
  CHECK(lines_in(outcome.err) == 1);
  CHECK(outcome.err.starts_with("swiftgs: "));
  for (const std::string& part : parts) {
    CAPTURE(part);
    CHECK(contains(outcome.err, part));
  }
}

void calibrate_builtin(const TemporaryFolder& place) {
  run(place, "calibrate builtin:300 --out b.json --renderers 'serial/adaptive/*/ellipse'" + small);
}

}  // namespace

TEST_CASE("cli calibrate: says which views and how long and what was chosen and where it is") {
  const TemporaryFolder place;
  const std::string text =
      run(place, "calibrate builtin:300 --out b.json --renderers 'serial/adaptive/*/ellipse'" + small).out;
  for (const char* part : {"serial with ellipse, 64x36, on ", "  standard ", "  early ", " ms +- ",
                           ", 3 views: ", "  choice   ", ", expected regret ", "b.json: 1 calibration\n"})
    CHECK(contains(text, part));
  const auto saved = swiftgs::read_sort_calibrations(place / "b.json");
  REQUIRE(saved.size() == 1);
  CHECK(saved[0].key.backend == "serial");
  CHECK(saved[0].key.bounds == "ellipse");
  CHECK(saved[0].key.library == swiftgs::version);
  CHECK(saved[0].key.scene == swiftgs::scene_checksum(swiftgs::make_builtin_scene(300)));
  CHECK(saved[0].measured.gaussians == 300);
  CHECK(saved[0].measured.width == 64);
  CHECK(saved[0].views == 3);
}

TEST_CASE("cli calibrate: each backend and bounds once and each size and again in place") {
  const TemporaryFolder place;
  const std::string command = "calibrate builtin:100 --out b.json --renderers 'serial/adaptive/*/*'";
  const auto calibrations = [](std::size_t sizes) {
    return "b.json: " + std::to_string(sizes * swiftgs::AllBounds::size) + " calibrations\n";
  };
  CHECK(contains(run(place, command + " --scale 0.02,0.03").out, calibrations(2)));
  std::set<std::string> cases;
  for (const auto& saved : swiftgs::read_sort_calibrations(place / "b.json"))
    cases.insert(saved.key.bounds + std::to_string(saved.measured.width));
  CHECK(cases.size() == 2 * swiftgs::AllBounds::size);
  CHECK(contains(run(place, command + " --scale 0.03").out, calibrations(2)));
  CHECK(contains(run(place, command + " --scale 0.04").out, calibrations(3)));
}

TEST_CASE("cli calibrate: the same seed chooses the same views") {
  const TemporaryFolder place;
  const auto views_with = [&](const std::string& seed) {
    const std::string text =
        run(place,
            "calibrate builtin:100 --out b.json --renderers serial/adaptive/per-pixel/ellipse --scale 0.02 "
            "--seed " +
                seed)
            .out;
    std::multiset<std::string> views;
    for (std::size_t at = 0; (at = text.find("orbit-", at)) != std::string::npos; at += 6)
      views.insert(text.substr(at, 8));
    return views;
  };
  CHECK(views_with("5") == views_with("5"));
  CHECK(views_with("5") != views_with("6"));
}

TEST_CASE("cli calibrate: a renderer finds the file beside the scene and draws the same image") {
  const TemporaryFolder place;
  write_scene(place / "scene.ply", swiftgs::make_builtin_scene(300));
  run(place, "render scene.ply --out without" + small + adaptive);
  run(place, "calibrate scene.ply --renderers 'serial/adaptive/*/ellipse'" + small);
  CHECK(swiftgs::read_sort_calibrations(place / "scene.ply.sort.json").size() == 1);
  run(place, "render scene.ply --out with" + small + adaptive);
  CHECK(content_of(place / "with/view.pfm") == content_of(place / "without/view.pfm"));
  run(place, "check scene.ply --repeats 1 --renderers serial/adaptive/per-pixel/ellipse" + small);

  // The name of a file and when it was written say nothing about its content.
  std::filesystem::copy_file(place / "scene.ply", place / "copy.ply");
  run(place, "render copy.ply --calibration scene.ply.sort.json" + small + adaptive);
  write_scene(place / "scene.ply", swiftgs::make_builtin_scene(301));
  run_with_notice(
      place, "render scene.ply" + small + adaptive,
      {"scene.ply.sort.json was calibrated for other content of the scene",
       "run: swiftgs calibrate scene.ply --scale 0.05 --renderers 'serial/adaptive/*/ellipse'\n"});
}

TEST_CASE("cli calibrate: a place that cannot be written is replaced by the cache where renderers look too") {
  const TemporaryFolder place;
  write_scene(place / "scene.ply", swiftgs::make_builtin_scene(300));
  std::filesystem::create_directory(place / "scene.ply.sort.json");
  const std::string text =
      run(place, "calibrate scene.ply --renderers 'serial/adaptive/*/ellipse'" + small).out;
  CHECK(contains(text, "cache/swiftgs/scene.ply-"));
  CHECK(contains(
      text, ": 1 calibration, as another place cannot be written: scene.ply.sort.json: Is a directory\n"));
  const auto bench = [&] {
    run(place,
        "bench scene.ply --scales 0.05 --errors none --min-frames 2 --max-frames 2 --json r.json "
        "--renderers serial/adaptive/per-pixel/ellipse");
    return json_in(place / "r.json")["rows"][0]["calibrated"].get<bool>();
  };
  CHECK(bench());
  run(place, "render ./scene.ply" + small + adaptive);
  std::filesystem::remove(place / "scene.ply.sort.json");
  CHECK(bench());
  std::filesystem::remove_all(place / "cache");
  CHECK_FALSE(bench());
}

TEST_CASE("cli calibrate: without any place it says so before it measures") {
  const TemporaryFolder place;
  write_scene(place / "scene.ply", swiftgs::make_builtin_scene(300));
  std::filesystem::create_directory(place / "scene.ply.sort.json");
  place.write("cache", "no folder");
  const Outcome outcome =
      swiftgs::test::swiftgs(place, "calibrate scene.ply --renderers 'serial/adaptive/*/ellipse'" + small);
  CHECK(outcome.code == 1);
  CHECK(outcome.out == "");
  CHECK(lines_in(outcome.err) == 1);
  CHECK(contains(outcome.err, "scene.ply.sort.json: Is a directory; "));
  CHECK(contains(outcome.err, "Not a directory; expected --out"));
}

TEST_CASE("cli calibrate: what does not fit is passed over in one line and the image is the same") {
  const TemporaryFolder place;
  calibrate_builtin(place);
  const std::string good = content_of(place / "b.json");
  const std::string render = "render builtin:300 --out out --calibration b.json" + small + adaptive;
  run(place, render);
  const std::string image = content_of(place / "out/front.pfm");
  CHECK(image.size() > 64 * 36 * 12);
  const auto with = [&](const std::string& from, const std::string& to, const std::string& notice) {
    std::string text = good;
    REQUIRE(contains(text, from));
    place.write("b.json", text.replace(text.find(from), from.size(), to));
    run_with_notice(place, render,
                    {notice,
                     "; the sort is measured while rendering; run: swiftgs calibrate builtin:300 "
                     "--scale 0.05 --out b.json --renderers 'serial/adaptive/*/ellipse'"});
    CHECK(content_of(place / "out/front.pfm") == image);
  };
  with("\"crc32:", "\"crc32:0", "b.json was calibrated for other content of the scene");
  with("\"library\":\"", "\"library\":\"9.", "b.json was calibrated by version 9.");
  with("\"device\":\"", "\"device\":\"Another ", "b.json was calibrated on 'Another ");
  with("\"serial\"", "\"cpu\"", "b.json holds no calibration of serial with ellipse");
  with("\"ellipse\"", "\"opacity-box\"", "b.json holds no calibration of serial with ellipse");
  with("\"width\":64", "\"width\":65", "b.json holds no calibration at 64x36");
  with("]}", "]", "b.json: byte ");
  with("\"early_ms\":", "\"early_ms\":-", "b.json: byte ");
  with(good, "", "b.json: byte 0: expected valid JSON");
  std::filesystem::remove(place / "b.json");
  run_with_notice(place, render, {"b.json is not there; the sort is measured while rendering"});
  std::filesystem::create_directory(place / "b.json");
  run_with_notice(place, render, {"b.json: Is a directory"});
}

TEST_CASE("cli calibrate: other sorts do not look for a file") {
  const TemporaryFolder place;
  place.write("b.json", "damaged");
  run(place, "render builtin:100 --calibration b.json --renderer serial/early/per-pixel/ellipse" + small);
}

TEST_CASE("cli calibrate: check compares the choice with both strategies and writes a row for each size") {
  const TemporaryFolder place;
  const std::string text = run(place,
                               "calibrate builtin:100 --out b.json --check --check-views 0,7 --json c.json "
                               "--renderers 'serial/adaptive/*/ellipse' --scale 0.02,0.03")
                               .out;
  CHECK(contains(text, "  check    2 views: standard "));
  CHECK(contains(text, " % of the frame, "));
  const json result = json_in(place / "c.json");
  CHECK(result["format"] == "swiftgs-calibration-check");
  CHECK(result["version"] == 1);
  CHECK(result["machine"]["version"] == swiftgs::version);
  CHECK(result["command"].get<std::string>().starts_with(
      "swiftgs calibrate builtin:100 --out b.json --check "));
  REQUIRE(result["rows"].size() == 2);
  for (const json& row : result["rows"]) {
    std::set<std::string> members;
    for (const auto& item : row.items()) members.insert(item.key());
    CHECK(members == std::set<std::string>{"scene", "gaussians", "width", "height", "device", "backend",
                                           "bounds", "views", "standard_ms", "early_ms", "adaptive_ms",
                                           "choice", "regret", "regret_error", "standard_sort_ms",
                                           "early_sort_ms", "adaptive_sort_ms", "sort_regret",
                                           "sort_regret_error"});
    CHECK(row["scene"] == "builtin");
    CHECK(row["gaussians"] == 100);
    CHECK(row["views"] == 2);
    const double standard = row["standard_ms"], early = row["early_ms"], chosen = row["adaptive_ms"];
    CHECK(row["regret"].get<double>() == doctest::Approx(chosen / std::min(standard, early) - 1));
    CHECK((row["choice"] == "early" || row["choice"] == "standard"));
  }
  CHECK(result["rows"][0]["width"] == 26);
  CHECK(result["rows"][1]["width"] == 38);
}

TEST_CASE("cli calibrate: a size without a view to check is said") {
  const TemporaryFolder place;
  write_scene(place / "scene.ply", swiftgs::make_builtin_scene(20));
  json cameras = json::array();
  for (const int width : {32, 48})
    cameras.push_back({{"id", 0},
                       {"img_name", std::to_string(width)},
                       {"width", width},
                       {"height", 16},
                       {"fx", 30.0},
                       {"fy", 30.0},
                       {"position", {0, 0, -5}},
                       {"rotation", {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}});
  place.write("cameras.json", cameras.dump());
  const std::string text = run(place,
                               "calibrate scene.ply --cameras cameras.json --check --check-views 1 "
                               "--renderers 'serial/adaptive/*/ellipse' --json c.json")
                               .out;
  CHECK(contains(text, "32x16"));
  CHECK(contains(text, "  check    none: of --check-views 1 none is 32x16\n"));
  CHECK(contains(text, "  check    1 view: standard "));
  CHECK(json_in(place / "c.json")["rows"].size() == 1);
}

TEST_CASE("cli calibrate: the command that a message says runs as it is in a shell") {
  const TemporaryFolder place;
  const std::string name = "a `scene`'s \"$HOME\" & more.ply";
  write_scene(place / name, swiftgs::make_builtin_scene(100));
  place.write(name + ".sort.json", "");
  const std::string quoted = "'a `scene`'\\''s \"$HOME\" & more.ply'";
  const Outcome outcome = swiftgs::test::swiftgs(place, "render " + quoted + small + adaptive);
  CAPTURE(outcome.err);
  CHECK(outcome.code == 0);
  const std::string before = "; run: swiftgs ";
  const std::size_t at = outcome.err.find(before);
  REQUIRE(at != std::string::npos);
  const std::string told = outcome.err.substr(at + before.size());
  run(place, told.substr(0, told.find('\n')));
  run(place, "render " + quoted + small + adaptive);
}

TEST_CASE("cli calibrate: what cannot be done is an error of one line before anything is measured") {
  const TemporaryFolder place;
  place.write("notes.txt", "nothing of ours");
  place.write("file", "");
  const char* cases[][2] = {
      {"calibrate builtin:100", "--out: expected a file"},
      {"calibrate builtin:100 --out notes.txt", "notes.txt: byte 0: expected a file of sort calibrations"},
      {"calibrate builtin:100 --out file/b.json", "file/b.json"},
      {"calibrate builtin:100 --out nowhere/b.json", "nowhere/b.json"},
      {"calibrate builtin:100 --out b.json --json c.json", "--json: expected --check"},
      {"calibrate builtin:100 --out b.json --check-views 0", "--check-views: expected --check"},
      {"calibrate builtin:100 --out b.json --check --json ./b.json",
       "--json ./b.json: expected another file"},
      {"calibrate scene.ply --out scene.ply", "--out scene.ply: expected another file than that of SCENE"},
      {"calibrate builtin:100 --out b.json --scale 0", "--scale"},
      {"calibrate builtin:100 --out b.json --scale 0.02,0.02",
       "--scale: expected factors that give different sizes, found 26x14 twice for the view front"},
      {"calibrate builtin:100 --out b.json --scale 0.02,0.02001", "found 26x14 twice"},
      {"calibrate builtin:100 --out b.json --check --check-views 99", "--views '99'"},
      {"calibrate builtin:100 --out b.json --renderers serial/early/per-pixel/ellipse",
       "the sort 'adaptive'"},
      {"calibrate builtin:100 --out b.json --renderers none", "--renderers 'none'"},
  };
  for (const auto& [command, part] : cases) {
    const std::string arguments = command;
    const Outcome outcome = swiftgs::test::swiftgs(place, arguments);
    CAPTURE(arguments);
    CAPTURE(outcome.err);
    CHECK(outcome.code == 1);
    CHECK(lines_in(outcome.err) == 1);
    CHECK(contains(outcome.err, part));
    CHECK(outcome.out == "");
  }
  CHECK(content_of(place / "notes.txt") == "nothing of ours");
}
