// SPDX-License-Identifier: Apache-2.0
#include <limits>

#include "io/png_encoder.hpp"
#include "report/browser.hpp"
#include "report/made_results.hpp"

using namespace swiftgs::test;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// What the page of result files shows; these are in `place` already.
Json facts_of_files(const TemporaryFolder& place, const std::string& files) {
  const Outcome outcome = swiftgs::test::swiftgs(place, "report " + files + " --out page.html");
  CAPTURE(outcome.err);
  REQUIRE(outcome.code == 0);
  CHECK(lines_in(outcome.out) == 1);
  const Json facts = found_in(place, content_of(place / "page.html"), source("tests/report/probe.js"));
  CHECK(facts["fault"] == "");
  CHECK(facts["asked"] == Json::array());
  CHECK(facts["unnamed"] == 0);
  return facts;
}

Json facts_of(const TemporaryFolder& place, const Json& results) {
  place.write("results.json", results.dump());
  return facts_of_files(place, "results.json");
}

/// Two that are exact, one that is quicker and less so, and two that others beat.
std::vector<Row> renderers() {
  return {{.renderer = "cpu/standard/per-pixel/opacity-box", .raster = 9, .psnr_db = 102},
          {.renderer = "cpu/standard/per-pixel/ellipse", .raster = 7, .psnr_db = 102},
          {.renderer = "cpu/early/axis-shared-threshold-float-cholesky/ellipse", .raster = 3, .psnr_db = 102},
          {.renderer = "cpu/early/axis-shared-half-split/ellipse", .raster = 2, .psnr_db = 62},
          {.renderer = "cpu/early/axis-shared-half-split/three-sigma-square", .raster = 4, .psnr_db = 61}};
}

/// The page of a result file shows the renderer `wrong` at `psnr_db`, and all others far above it. Made rows
/// and measured ones are judged alike.
void shows_apart(const TemporaryFolder& place, const std::string& file, const std::string& wrong,
                 double psnr_db) {
  const Json points = facts_of_files(place, file)["points"];
  REQUIRE(points.contains(wrong));
  REQUIRE(points.size() > 1);
  for (const auto& point : points.items()) {
    const double shown = point.value();
    CAPTURE(point.key());
    if (point.key() == wrong)
      CHECK(std::abs(shown - psnr_db) < 0.5);
    else
      CHECK(shown > psnr_db + 20);
  }
}

}  // namespace

TEST_CASE("report: every renderer is drawn in every plot and stands in a table that sorts and filters") {
  const TemporaryFolder place;
  if (!can_draw(place)) return;
  const Json facts = facts_of(place, results_of(renderers()));
  CHECK(facts["marks"]["#pareto .points path"] == 5);
  CHECK(facts["marks"]["#stages .segments path"] == 15);
  CHECK(facts["marks"]["#stages .intervals line"] == 5);
  CHECK(facts["marks"]["#speedups .bars path"] == 3);  // those with the bounds that are chosen first
  // 12 ms of the baseline over 10, 6 and 5.
  CHECK(facts["bars"] == Json({1.2, 2.0, 2.4}));

  // Exactly what no other beats.
  CHECK(facts["front"] == Json({"cpu/early/axis-shared-half-split/ellipse",
                                "cpu/early/axis-shared-threshold-float-cholesky/ellipse"}));
  CHECK(facts["marks"]["#pareto .front_points path"] == 2);

  CHECK(facts["is_button"] == true);
  const Json up = facts["sorted"][0], down = facts["sorted"][1];
  CHECK(up["aria"] == "ascending");
  CHECK(down["aria"] == "descending");
  CHECK(up["order"][0] == "cpu/early/axis-shared-half-split/ellipse");
  CHECK(up["order"][4] == "cpu/standard/per-pixel/opacity-box");
  CHECK(down["order"][0] == up["order"][4]);
  CHECK(down["order"][4] == up["order"][0]);
  CHECK(facts["filtered"] == Json({"cpu/standard/per-pixel/ellipse"}));
}

TEST_CASE("report: an error of 1e-3 stands at 60 dB apart from exact renderers") {
  const TemporaryFolder place;
  if (!can_draw(place)) return;
  std::vector<Row> rows = renderers();
  rows.resize(3);
  rows.push_back({.renderer = "cpu/early/off-by-a-thousandth/ellipse", .psnr_db = -20 * std::log10(1e-3)});
  place.write("results.json", results_of(rows).dump());
  shows_apart(place, "results.json", "cpu/early/off-by-a-thousandth/ellipse", 60);
}

TEST_CASE("report: a measured policy that is off by 1e-3 stands at 60 dB apart from exact ones") {
  const TemporaryFolder place;
  if (!can_draw(place)) return;
  if (!std::filesystem::exists(SWIFTGS_FLAWED_RESULTS)) return skip("flawed_policies has not measured here");
  shows_apart(place, "'" SWIFTGS_FLAWED_RESULTS "'", "serial/early/off-by-a-thousandth/ellipse", 60);
}

TEST_CASE("report: an infinite PSNR stands above all others") {
  const TemporaryFolder place;
  if (!can_draw(place)) return;
  std::vector<Row> rows = renderers();
  rows[1].psnr_db = infinity;
  rows[4].psnr_db = std::numeric_limits<double>::quiet_NaN();
  const Json facts = facts_of(place, results_of(rows));
  CHECK(facts["infinite"] == true);
  CHECK(facts["marks"]["#pareto .points path"] == 4);
  CHECK(facts["points"][rows[1].renderer].get<double>() > 103);
  check_holds(facts["text"], {"One renderer without a measured error"});
}

TEST_CASE("report: growth of n to the 0.8 is fitted as 0.80") {
  const TemporaryFolder place;
  if (!can_draw(place)) return;
  std::vector<Row> rows;
  for (const double n : {1e5, 1e6, 4e6, 1.2e7})
    rows.push_back(
        {.project = 1e-5 * n, .sort = 1e-4 * std::pow(n, 0.8), .raster = 2, .gaussians = n, .bytes = 50 * n});
  const Json facts = facts_of(place, results_of(rows));
  REQUIRE(facts["scaling"].size() == 1);
  const Json growth = facts["scaling"]["gaussians"];
  CHECK(growth["points"] == 20);  // three stages, their sum and memory
  check_holds(growth["legend"].dump(), {"project: exponent 1.00", "sort: exponent 0.80",
                                        "raster: exponent 0.00", "memory: exponent 1.00"});
  CHECK(growth["exponents"][1] == "0.80");
  // 1e-5 n is 2 there, and 1e-4 n^0.8 less.
  CHECK(growth["dominance"] == "raster is the longest stage at first, project from 200 k Gaussians on.");
}

TEST_CASE("report: memory of each stage and of all grows as the buffers of files that know them") {
  const TemporaryFolder place;
  if (!can_draw(place)) return;
  std::vector<Row> rows;
  for (const double n : {1e5, 1e6, 1e7})
    rows.push_back({.gaussians = n, .bytes = 7, .stage_bytes = {50 * n, 4 * n * n, 1e6}});
  const Json growth = facts_of(place, results_of(rows))["scaling"]["gaussians"];
  CHECK(growth["points"] == 24);  // of times and of memory three stages and their sum
  check_holds(growth["legend"].dump(), {"project memory: exponent 1.00", "sort memory: exponent 2.00",
                                        "raster memory: exponent 0.00", "\"memory: exponent 2.0"});
}

TEST_CASE("report: what files do not hold is named and not drawn") {
  const TemporaryFolder place;
  if (!can_draw(place)) return;
  const Json facts = facts_of(place, results_of({{.psnr_db = std::numeric_limits<double>::quiet_NaN()}}));
  CHECK(facts["shown"] == Json({"stages"}));
  check_holds(facts["missing"], {"errors against float64", "a baseline", "Gaussians", "threads", "images"});
}

TEST_CASE("report: texts of files stay texts") {
  const TemporaryFolder place;
  if (!can_draw(place)) return;
  const std::string name = "</script><script>throw 1</script><!-- \" & \u2028 {{data}} é <b>bold</b>";
  Json results = results_of({{.scene = name}, {.renderer = "cpu/early/</script>/ellipse", .scene = name}});
  results["command"] = name;
  const Json facts = facts_of(place, results);
  check_holds(facts["text"], {name});
  CHECK(facts["marks"]["#pareto .points path"] == 2);
}

TEST_CASE("report: files of several machines and of hard frames share one page") {
  const TemporaryFolder place;
  if (!can_draw(place)) return;
  place.write("a.json", results_of(renderers()).dump());
  place.write("b.json", results_of(renderers()).dump());
  place.write("stress.json", stress_results_of({{}, {.severity = 1e4}}).dump());
  const Json facts = facts_of_files(place, "stress.json a.json b.json");
  CHECK(facts["marks"]["#pareto .points path"] == 10);
  check_holds(facts["sorted"][0]["order"].dump(), {"ellipse · b.json"});
  check_holds(facts["text"], {"swiftgs stress made", "needles: largest error"});
}

TEST_CASE("report: frames stand beside their reference and error map") {
  const TemporaryFolder place;
  if (!can_draw(place)) return;
  const std::string one_pixel = png({.colour = png_grey, .rows = std::string("\0h", 2)});
  for (const char* name :
       {"images/frame.png", "images/error.png", "images/reference.png", "images/depth.png"})
    place.write(name, one_pixel);
  Json results = results_of({{}});
  results["rows"][0]["image"] = "images/frame.png";
  results["rows"][0]["error_image"] = "images/error.png";
  results["rows"][0]["plane_images"] = {{{"plane", "median_depth"}, {"image", "images/depth.png"}}};
  results["views"][0]["reference_image"] = "images/reference.png";
  const Json facts = facts_of(place, results);
  REQUIRE(facts["images"].size() == 2);
  for (const Json& image : facts["images"]) {
    CHECK(image["source"] == "data:image/png;base64,");
    CHECK(image["width"] == 1);
  }
  CHECK(facts["errorLegend"] == true);
  CHECK(facts["ways"] == Json({"slider", "frame", "reference", "error map", "median depth"}));
  CHECK(facts["planeShown"] == Json({"median_depth of cpu/early/per-pixel/ellipse"}));
}

TEST_CASE("report: hard frames have a panel of normalised errors and one of errors for each family") {
  const TemporaryFolder place;
  if (!can_draw(place)) return;
  std::vector<StressRow> rows;
  for (const char* backend : {"cpu", "serial"})
    for (const double severity : {1e2, 1e4, infinity}) {
      rows.push_back({.severity = severity, .ratio = severity == 1e4 ? 10.0 : 1.0, .backend = backend});
      rows.push_back({.severity = severity,
                      .ratio = severity == 1e4 ? 100.0 : infinity,
                      .backend = backend,
                      .raster = "axis-shared-half-split"});
      rows.push_back(
          {.family = "ridges", .severity = severity, .ratio = 0, .max_abs = 0, .backend = backend});
    }
  rows.back().failed = 8;
  place.write("stress.json", stress_results_of(rows).dump());
  REQUIRE(swiftgs::test::swiftgs(place, "report stress.json --out page.html").code == 0);
  const Json facts = found_in(place, content_of(place / "page.html"), source("tests/report/probe_stress.js"));
  CHECK(facts["fault"] == "");
  CHECK(facts["shown"] == Json({"stress"}));
  CHECK(facts["names"] == Json({"needles: strict normalised error", "needles: largest error",
                                "ridges: strict normalised error", "ridges: largest error"}));
  // Both quantities of every row but the one that failed.
  CHECK(facts["points"] == 2 * (rows.size() - 1));
  CHECK(facts["curves"] == 2 * 6);
  // The rules of the first panel lie where points of these errors do, and an infinite one is drawn above.
  CHECK(facts["rules"] == Json({facts["heights"]["10"], facts["heights"]["100"]}));
  CHECK(facts["heights"]["infinite"] < facts["heights"]["100"]);
  CHECK(facts["ticks"] == Json({"100", "1e4", "∞"}));
  CHECK(facts["backends"] == Json({"cpu", "serial"}));
  check_holds(facts["note"], {"serial/early/per-pixel/ellipse: seed 1: no <memory>"});
  CHECK(facts["rows"] == rows.size());
  CHECK(facts["of_one_backend"] == 9);
}

TEST_CASE("report: figures are saved for other pages") {
  const TemporaryFolder place;
  if (!can_draw(place)) return;
  place.write("results.json", results_of(renderers()).dump());
  place.write("stress.json", stress_results_of({{}, {.backend = "cuda"}}).dump());
  REQUIRE(swiftgs::test::swiftgs(place, "report results.json stress.json --out page.html").code == 0);
  const std::string folder = place.path().string();
  const std::string command = "TMPDIR='" + folder +  // where the browser's profile is left
                              "' SWIFTGS_BROWSER='" SWIFTGS_BROWSER "' '" SWIFTGS_SOURCES
                              "/benchmarks/figures.sh' '" +
                              folder + "/page.html' '" + folder + "/figures' >'" + folder + "/listed.txt'";
  REQUIRE(std::system(command.c_str()) == 0);
  CHECK(lines_in(content_of(place / "listed.txt")) == 5);
  for (const std::string name :
       {"pareto-made", "stages-made", "speedup-made", "stability-cpu", "stability-gpu"}) {
    const std::string svg = content_of(place / ("figures/" + name + ".svg"));
    CAPTURE(name);
    CHECK(svg.starts_with("<svg "));
    CHECK(svg.ends_with("</svg>"));
    check_holds(svg, {"fill=\"#ffffff\""});  // legible on a dark page too
  }
}
