// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <fstream>
#include <initializer_list>
#include <set>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "cli/background_run.hpp"
#include "cli/command.hpp"
#include "cli/json_in.hpp"

namespace swiftgs::test::bench_cli_test {

namespace {

void fails(const std::string& arguments, std::initializer_list<std::string> words) {
  swiftgs::test::fails(TemporaryFolder(), "bench " + arguments, words);
}

const std::string one = " --renderers 'serial/early/per-pixel/ellipse'";

/// The results of a quick measurement, which prints into `stdout.txt`.
json measured(const TemporaryFolder& place, const std::string& arguments,
              const std::string& max_frames = "4") {
  const std::string quick = " --scales 0.1 --min-frames 2 --json r.json --max-frames " + max_frames;
  const Outcome outcome = swiftgs::test::swiftgs(place, "bench " + arguments + quick);
  REQUIRE_MESSAGE(outcome.code == 0, outcome.err);
  return json_in(place / "r.json");
}

}  // namespace

TEST_CASE("bench: every combination has a row and every row what the schema says") {
  const TemporaryFolder place;
  const json results =
      measured(place,
               "builtin:500 --renderers 'serial/*/per-pixel/ellipse,serial/early/per-pixel/three*' "
               "--views 0,2 --conventions gsplat,inria --gaussians 300,900");
  check_holds(content_of(place / "stdout.txt"), {"| `serial/standard/per-pixel/ellipse` | 2 |"});
  CHECK(
      results.at("command").get<std::string>().starts_with("swiftgs bench builtin:500 --renderers 'serial/"));
  for (const char* member :
       {"date", "cpu", "cores", "memory_gib", "system", "compiler", "flags", "commit", "version", "load"})
    CHECK(results.at("machine").contains(member));
  CHECK(results.at("scenes").size() == 2);
  CHECK(results.at("views").size() == 2 * 2 * 2);
  REQUIRE(results.at("rows").size() == 4 * 2 * 2 * 2);
  for (const json& row : results.at("rows")) {
    CAPTURE(row.dump());
    CHECK(row.at("renderer") ==
          row.at("backend").get<std::string>() + "/" + row.at("sort").get<std::string>() + "/" +
              row.at("raster").get<std::string>() + "/" + row.at("bounds").get<std::string>());
    for (const char* stage : {"project", "sort", "raster", "total", "wall"}) {
      const json& ms = row.at("ms").at(stage);
      CHECK(ms.at("low") <= ms.at("median"));
      CHECK(ms.at("median") <= ms.at("high"));
      CHECK(ms.at("p10") <= ms.at("p90"));
    }
    CHECK(row.at("ms").at("total").at("median") <= row.at("ms").at("wall").at("high"));
    check_members(row, R"({"batch": 1, "planes": "", "photo_psnr_db": null, "device_bytes": 0})");
    CHECK(row.at("frames").get<int>() >= 2);
    const bool cut = row.at("bounds") == "three-sigma-square";
    CHECK(row.at("cut_psnr_db").is_number() == cut);
    CHECK(row.at(cut ? "cut_psnr_db" : "psnr_db").get<double>() > 90);
    CHECK(row.at("ssim").get<double>() > 0.99);
    CHECK(row.at("visible") > 0);
    CHECK(row.at("intersections") >= row.at("visible"));
    CHECK(row.at("contributing_pairs") > 0);
  }
}

TEST_CASE("bench: a batch changes nothing of a row but its times") {
  const TemporaryFolder place;
  const std::string bench = "builtin:500 --views 0,2,5" + one;
  const json single = measured(place, bench, "2").at("rows"),
             four = measured(place, bench + " --batch 4", "2").at("rows");
  REQUIRE(four.size() == 3);
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(four[i].at("batch") == 4);
    for (const char* member :
         {"view", "renderer", "frames", "psnr_db", "ssim", "visible", "intersections", "contributing_pairs"})
      CHECK(four[i].at(member) == single[i].at(member));
    CHECK(four[i].at("ms").at("total").at("median") > 0);
    // The frame holds four views.
    CHECK(four[i].at("bytes").at("raster").get<double>() >
          3 * single[i].at("bytes").at("raster").get<double>());
  }
}

TEST_CASE("bench: planes are drawn and named in the rows") {
  const TemporaryFolder place;
  const std::string command = "builtin:500 --views 0" + one;
  const json plain = measured(place, command).at("rows")[0],
             row = measured(place, command + " --planes alpha,depth,normal,id").at("rows")[0];
  CHECK(row.at("planes") == "alpha,depth,normal,id");
  CHECK(row.at("bytes").at("raster").get<double>() > plain.at("bytes").at("raster").get<double>());
}

TEST_CASE("bench: rows say how they were measured, and errors are of the views that are asked for") {
  const TemporaryFolder place;
  const std::string bench = "builtin:500 --views 0,2 --errors 1 --threads 1 --enlarge 1,4" + one;
  for (const std::string kept : {"float", "half"}) {
    const json rows = measured(place, bench + " --harmonics " + kept).at("rows");
    REQUIRE(rows.size() == 4);
    for (const json& row : rows) {
      check_members(row,
                    R"({"threads": 1, "harmonics": ")" + (kept == "half" ? "halves" : kept + "s") + "\"}");
      CHECK(row.at("psnr_db").is_number() == (row.at("view") == "front"));
      CHECK(row.at("max_abs").is_number() == (row.at("view") == "front"));
    }
    CHECK(rows[2].at("enlarge") == 4);
    CHECK(rows[2].at("view") == rows[0].at("view"));
    CHECK(rows[2].at("intersections") > rows[0].at("intersections"));
  }
}

TEST_CASE("bench: --model says how scenes were trained, for frames and for what they are compared with") {
  const TemporaryFolder place;
  const std::string bench = "builtin:500 --views 0" + one, model = "blur=0.5,antialiased=yes,order=distance";
  const json as_usual = measured(place, bench), changed = measured(place, bench + " --model " + model);
  CHECK(as_usual.at("scenes")[0].at("model") == "");
  CHECK(changed.at("scenes")[0].at("model") == model);
  CHECK(changed.at("rows")[0].at("intersections") != as_usual.at("rows")[0].at("intersections"));
  CHECK(changed.at("rows")[0].at("psnr_db").get<double>() > 90);
  fails("builtin:500 --model kernel=disk" + one, {"--model kernel=disk: expected no kernel"});
}

TEST_CASE("bench: with --profile every view is drawn by every renderer and nothing is written") {
  const TemporaryFolder place;
  const Outcome outcome = run(place,
                              "bench builtin:500 --profile --renderers 'serial/*/per-pixel/ellipse' "
                              "--views 0,2 --scales 0.1 --conventions gsplat,inria");
  CHECK(lines_in(outcome.out) == 3 * 2 * 2);
  check_holds(outcome.out,
              {"serial/early/per-pixel/ellipse: builtin, 500 Gaussians, view front, 128x72, gsplat\n",
               "serial/adaptive/per-pixel/ellipse: builtin, 500 Gaussians, view orbit-01, 128x72, inria\n"});
  CHECK(!contains(outcome.out, "|"));
  CHECK(files_in(place.path()) == std::set<std::string>{"stderr.txt", "stdout.txt"});
}

TEST_CASE("bench: options that say how to measure are refused beside --profile") {
  for (const std::string option :
       {"--errors all", "--precision 0.1", "--min-frames 2", "--max-frames 9", "--json r.json", "--resume"})
    fails("builtin:500 --profile " + option, {option.substr(0, option.find(' ')), "--profile"});
}

TEST_CASE("bench: what cannot be measured is one line that says why") {
  fails("nothing.spz", {"nothing.spz"});
  fails(".", {"expected a capture"});
  fails("builtin:500 --renderers 'serial/*,gpu/*'", {"gpu/*", "swiftgs list"});
  fails("builtin:500 --views 99", {"--views", "99"});
  fails("builtin:500 --scales 0,1", {"--scales '0,1': expected finite"});
  fails("builtin:500 --scales 1,,2", {"--scales", "1,,2"});
  fails("builtin:500 --gaussians few", {"--gaussians", "few"});
  for (const std::string factor : {"0", "-1"})
    fails("builtin:500 --enlarge=" + factor, {"--enlarge " + factor + ": expected factors"});
  fails("builtin:500 --threads 100000", {"--threads"});
  fails("builtin:500 --conventions paper", {"paper", "gsplat"});
  fails("builtin:500 --errors some", {"--errors"});
  fails("builtin:500 --min-frames 0", {"--min-frames"});
  fails("builtin:500 --max-frames 2 --min-frames 3", {"--max-frames"});
  fails("builtin:500 --precision 0", {"--precision"});
  fails("same.ply --json same.ply", {"same.ply"});
  fails("builtin:500 --threads 0", {"--threads 0: expected 1 to"});
  fails("builtin:500 --threads -1", {"--threads '-1'"});
  fails("builtin:500 --gaussians 0", {"--gaussians", "100000000"});
  fails("builtin:500 --gaussians 18446744073709551615", {"--gaussians", "100000000"});
  fails("builtin:500 --enlarge 1e39", {"--enlarge", "1000"});
  fails("builtin:500 --enlarge 1e-50", {"--enlarge", "0.001"});
  fails("builtin:500 --json no/such/folder/r.json", {"no/such/folder"});
}

TEST_CASE("bench: what would be measured twice under one name is refused") {
  fails("builtin:500 --scales 0.1,.1", {"--scales", "once"});
  fails("builtin:500 --conventions gsplat,gsplat", {"--conventions", "once"});
  fails("builtin:500 --threads 1,1", {"--threads", "once"});
  fails("builtin:500 builtin:500", {"SCENE", "builtin:500", "another name"});
  fails("builtin:500 builtin:600 --gaussians 100", {"SCENE", "builtin:600", "another name"});
}

namespace {

const std::string resumable =
    "builtin:300 --renderers 'serial/*/per-pixel/ellipse' --views 0,2 --gaussians 200,300";

void write_json(const TemporaryFolder& place, const json& results) {
  std::ofstream(place / "r.json") << results.dump();
}

/// What `--resume` makes of the file at `place`.
json resumed(const TemporaryFolder& place, const std::string& arguments) {
  return measured(place, arguments + " --resume");
}

}  // namespace

TEST_CASE("bench: --resume keeps the rows of a stopped run and measures the others") {
  const TemporaryFolder place;
  const json whole = measured(place, resumable);
  CHECK(whole == resumed(place, resumable));  // nothing is left to measure
  // As a run leaves it that was stopped in the second view of the first scene.
  json stopped = whole;
  stopped["rows"].erase(stopped["rows"].begin() + 4, stopped["rows"].end());
  stopped["views"].erase(stopped["views"].begin() + 2, stopped["views"].end());
  stopped["scenes"].erase(1);
  stopped["rows"][1]["ms"]["total"]["median"] = 1e6;
  write_json(place, stopped);
  const json results = resumed(place, resumable);
  CHECK(results.at("command") == whole.at("command"));
  CHECK(results.at("scenes") == whole.at("scenes"));
  CHECK(results.at("views") == whole.at("views"));
  REQUIRE(results.at("rows").size() == 3 * 2 * 2);
  for (std::size_t i = 0; i < 12; ++i) {
    if (i < 4) CHECK(results.at("rows")[i] == stopped.at("rows")[i]);
    for (const char* member : {"gaussians", "view", "renderer", "psnr_db", "intersections"})
      CHECK(results.at("rows")[i].at(member) == whole.at("rows")[i].at(member));
  }
  check_holds(content_of(place / "stdout.txt"), {"| 500"});  // half of it, as the mean has two views
}

TEST_CASE("bench: --resume begins where no file is and needs a file to be named") {
  const TemporaryFolder place;
  CHECK(resumed(place, "builtin:300 --views 0" + one).at("rows").size() == 1);
  fails("builtin:300 --resume", {"--resume: expected --json FILE"});
  fails("builtin:300 --resume --json -", {"--resume: expected --json FILE"});
}

TEST_CASE("bench: --resume refuses a file of something else and leaves it as it is") {
  const TemporaryFolder place;
  const std::string command = "builtin:300 --views 0" + one;
  const json whole = measured(place, command);
  const std::string resume =
      "bench " + command + " --scales 0.1 --min-frames 2 --json r.json --max-frames 4 --resume";
  const auto refuses = [&](const std::string& pointer, const json& value,
                           std::initializer_list<std::string> parts) {
    json changed = whole;
    changed[json::json_pointer(pointer)] = value;
    write_json(place, changed);
    const std::string before = content_of(place / "r.json");
    swiftgs::test::fails(place, resume, parts);
    CHECK(content_of(place / "r.json") == before);
  };
  refuses("/machine/cpu", "another", {"--resume r.json: machine.cpu is \"another\"; expected \""});
  refuses("/machine/commit", "abc", {"machine.commit is \"abc\"; expected \""});
  refuses("/machine/gpu", "a GPU", {"machine.gpu is \"a GPU\"; expected "});
  refuses("/command", "swiftgs bench garden",
          {"command is \"swiftgs bench garden\"; expected \"swiftgs bench "});
  refuses("/scenes/0/geometry", "other", {"scene builtin has changed; expected the Gaussians"});
  refuses("/scenes/0/model", "antialiased=yes", {"expected the Gaussians and the model"});
  refuses("/format", "swiftgs-stress", {"format is \"swiftgs-stress\"; expected \"swiftgs-bench\""});
  refuses("/rows/0/frames", "few", {"--resume r.json: expected what bench has written"});
  refuses("/rows", json{{"a", 1}}, {"--resume r.json: expected what bench has written"});
  for (const std::string text : {"", "[]", "{\"format\": \"swiftgs-bench\"", "\xff"}) {
    std::ofstream(place / "r.json") << text;
    swiftgs::test::fails(place, resume, {"--resume r.json: "});
  }
}

TEST_CASE("bench: Ctrl-C leaves the rows so far, tells how to go on, and ends the tool as a signal does") {
  const TemporaryFolder place;
  const std::vector<std::string> command{
      "bench",    "builtin:300", "--renderers",  "serial/*/per-pixel/ellipse",
      "--views",  "all",         "--scales",     "0.1",
      "--errors", "none",        "--min-frames", "2",
      "--json",   "r.json",      "--max-frames", "4"};
  BackgroundRun tool(place, command);
  REQUIRE(tool.shows("] 2/"));
  tool.press_ctrl_c();
  CHECK(tool.wait() == -1);
  CHECK(contains(tool.shown(), "swiftgs: r.json: cancelled after "));
  CHECK(contains(tool.shown(), " rows; the same command with --resume measures the others"));
  const std::size_t rows = json_in(place / "r.json").at("rows").size();
  CHECK(rows >= 2);
  CHECK(contains(content_of(place / "stdout.txt"), "| `serial/"));
  CHECK(files_in(place.path()) == std::set<std::string>{"r.json", "stdout.txt"});
}

}  // namespace swiftgs::test::bench_cli_test
