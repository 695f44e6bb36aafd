// SPDX-License-Identifier: Apache-2.0
#include <initializer_list>
#include <set>
#include <string>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include <swiftgs/bounds/all.hpp>
#include <swiftgs/sort/all.hpp>
#include <swiftgs/version.hpp>

#include "cli/command.hpp"
#include "cli/json_in.hpp"

namespace swiftgs::test::stress_cli_test {

namespace {

void fails(const std::string& arguments, std::initializer_list<std::string> words) {
  swiftgs::test::fails(TemporaryFolder(), "stress " + arguments, words);
}

const std::string one = " --renderers serial/early/per-pixel/ellipse --seeds 1 ";

}  // namespace

TEST_CASE("stress: a sweep of one family ends well and prints a line for each renderer") {
  const TemporaryFolder place;
  const std::string text =
      run(place, "stress --families needles --severity max --seeds 1 --renderers 'serial/early/*/ellipse'")
          .out;
  CHECK(contains(text, "\nneedles, length over width up to 1e10: 64x48, 1 seed "));
  CHECK(contains(text, "\n  serial/early/per-pixel/ellipse "));
  for (const char* raster : {"per-pixel", "axis-shared-threshold-float-cholesky"})
    CHECK(contains(text, "\nserial/early/" + std::string(raster) + "/ellipse: exact in 1 family;"));
  CHECK(contains(text, "\nwarning: serial/early/axis-shared-half-split/ellipse: "));
  CHECK(contains(text, " of a colour from needles 1e10 ("));
  CHECK_FALSE(contains(text, "warning: serial/early/per-pixel/ellipse"));
  // Half terms lose digits and keep within what their exponent representation is allowed to err: that is no
  // failure.
  CHECK(contains(text, "\nserial/early/axis-shared-half-split/ellipse: loses digits from needles 1e10;"));
}

TEST_CASE("stress: results have a head and a row for each family with severity and size") {
  const TemporaryFolder place;
  run(place,
      "stress --families little-blur,needles --size 16x12,20x10 --seeds 2 --json r.json"
      " --renderers 'serial/early/per-pixel/ellipse,serial/standard/axis-shared-half-split/ellipse'");
  const json results = json_in(place / "r.json");
  CHECK(results.at("format") == "swiftgs-stress");
  CHECK(results.at("machine").at("version") == swiftgs::version);
  CHECK(
      results.at("command").get<std::string>().starts_with("swiftgs stress --families little-blur,needles "));
  REQUIRE(results.at("rows").size() == 2 * 2 * 10);
  std::set<std::string> places;
  for (const json& row : results.at("rows")) {
    CAPTURE(row.dump());
    places.insert(row.at("family").dump() + row.at("severity").dump() + row.at("width").dump() +
                  row.at("renderer").dump());
    CHECK(row.at("severity_label") ==
          (row.at("family") == "needles" ? "length over width" : "1 / blur (1/px^2)"));
    CHECK(row.at("height") == (row.at("width") == 16 ? 12 : 10));
    CHECK(row.at("seeds") == 2);
    CHECK(row.at("normalised_error") <= 10);
  }
  CHECK(places.size() == results.at("rows").size());
  CHECK(places.contains("\"little-blur\"null16\"serial/early/per-pixel/ellipse\""));
}

TEST_CASE("stress: bounds that cut splats end with exit code 1 after table and results") {
  const TemporaryFolder place;
  const Outcome outcome =
      swiftgs::test::swiftgs(place,
                             "stress --families pancakes --severity 1e4 --seeds 2 --json r.json"
                             " --renderers 'serial/early/per-pixel/*'");
  CAPTURE(outcome.err);
  CHECK(outcome.code == 1);
  CHECK(lines_in(outcome.err) == 1);
  CHECK(contains(outcome.err,
                 "up to 10; 1 of " + std::to_string(swiftgs::AllBounds::size) + " rows are above"));
  CHECK(contains(outcome.err, "serial/early/per-pixel/three-sigma-square on pancakes at 1e4"));
  CHECK(contains(outcome.out, "serial/early/per-pixel/three-sigma-square: loses digits from pancakes 1e4;"));
  CHECK(contains(outcome.out, "serial/early/per-pixel/ellipse: exact in 1 family;"));
  CHECK(json_in(place / "r.json").at("rows").size() == swiftgs::AllBounds::size);
}

TEST_CASE("stress: a search prints what it found and writes a row for each family and plane") {
  const TemporaryFolder place;
  const std::string text =
      run(place,
          "stress --search 0.3 --seed 7 --families equal-stacks,backgrounds --json r.json"
          " --renderers 'serial/*/per-pixel/ellipse'")
          .out;
  CHECK(contains(text, "serial/early/per-pixel/ellipse: worst normalised error "));
  CHECK(contains(text, " of colour from equal-stacks\n"));
  const json results = json_in(place / "r.json");
  CHECK(results.at("format") == "swiftgs-stress-search");
  REQUIRE(results.at("rows").size() == swiftgs::AllSorts::size * 2 * 2);
  std::set<std::string> places;
  for (const json& row : results.at("rows")) {
    CAPTURE(row.dump());
    places.insert(row.at("renderer").dump() + row.at("family").dump() + row.at("plane").dump());
    CHECK(row.at("tries") > 0);
    CHECK(row.at("normalised_error") <= 10);
  }
  CHECK(places.size() == results.at("rows").size());
}

TEST_CASE("stress: options that make no sense are one line with what was typed and expected") {
  fails("--families needle" + one,
        {"--families 'needle'", "expected some of needles, bare-needles", "mixtures"});
  fails("--families needles,needles" + one, {"--families 'needles,needles'", "once"});
  fails("--severity most" + one, {"--severity 'most'", "max, all"});
  fails("--severity nan --families needles" + one, {"--severity 'nan'", "100 to 1e10 for needles"});
  fails("--severity 1e12 --families needles" + one,
        {"--severity '1e12'", "100 to 1e10", "length over width"});
  fails("--size 64" + one, {"--size '64'", "WIDTHxHEIGHT"});
  fails("--size 0x48" + one, {"--size '0x48'", "1 to 65536"});
  fails("--size 64x48x" + one, {"--size '64x48x'", "WIDTHxHEIGHT"});
  fails("--seeds 0", {"--seeds 0", "1 to"});
  fails("--seeds many", {"--seeds", "many"});
  fails("--search 0", {"--search 0", "above 0"});
  fails("--search soon", {"--search", "soon"});
  fails("--search 1 --families needle", {"--families 'needle'", "edge-on-disks"});
  fails("--search 1 --seeds 3", {"--seeds", "--search"});
  fails("--search 1 --size 16x16", {"--size", "--search"});
  fails("--seed 3", {"--seed", "--search"});
  for (const std::string threads : {"0", "-1", "100000"})
    fails("--threads " + threads + one, {"--threads " + threads + ": expected 1 to"});
  fails("--renderers nothing", {"--renderers 'nothing'", "swiftgs list"});
  fails("--json no/such/folder/r.json" + one, {"no/such/folder"});
}

}  // namespace swiftgs::test::stress_cli_test
