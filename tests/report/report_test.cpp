// SPDX-License-Identifier: Apache-2.0

// `swiftgs report` on made results, whose page a browser draws.
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "cli/command.hpp"
#include "support/skip.hpp"

using namespace swiftgs::test;

namespace {

using Json = nlohmann::json;

/// A text that would end the page's data and run, if it were not escaped.
const std::string hostile = "</script><script>throw 1</script><!-- \" & {{data}} <b>bold</b>";

Json duration(double ms) {
  return {{"median", ms}, {"low", 0.99 * ms}, {"high", 1.02 * ms}, {"p10", 0.98 * ms}, {"p90", 1.05 * ms}};
}

/// A row of `swiftgs bench`: projection takes 1 ms, the sort 2 ms. An infinite PSNR is null, as in its files.
Json row_of(const std::string& scene, double gaussians, const std::string& sort, const std::string& raster,
            const std::string& bounds, double raster_ms, double psnr_db) {
  const bool differs = std::isfinite(psnr_db);
  return {{"scene", scene},
          {"gaussians", gaussians},
          {"enlarge", 1},
          {"view", "front"},
          {"width", 640},
          {"height", 480},
          {"scale", 1},
          {"conventions", "gsplat"},
          {"threads", 4},
          {"renderer", "cpu/" + sort + "/" + raster + "/" + bounds},
          {"backend", "cpu"},
          {"sort", sort},
          {"raster", raster},
          {"bounds", bounds},
          {"frames", 20},
          {"ms",
           {{"project", duration(1)},
            {"sort", duration(2)},
            {"raster", duration(raster_ms)},
            {"total", duration(3 + raster_ms)},
            {"wall", duration(4 + raster_ms)}}},
          {"psnr_db", differs ? Json(psnr_db) : Json()},
          {"max_abs", differs ? 0.001 : 0.0},
          {"host_bytes", 50 * gaussians}};
}

Json file_of(const char* format, const Json& rows) {
  Json file{{"format", format},
            {"version", 1},
            {"machine", {{"date", "2026-01-02"}, {"cpu", "A processor"}, {"commit", "0123+"}}},
            {"command", hostile},
            {"scenes", Json::array()},
            {"rows", rows}};
  for (const Json& row : rows)
    file["scenes"].push_back({{"scene", row["scene"]},
                              {"gaussians", row["gaussians"]},
                              {"original", row["gaussians"]},
                              {"enlarge", row["enlarge"]}});
  return file;
}

/// Two that others beat, one that is exact, and the quickest two, of which the first loses digits.
Json compared() {
  const std::string half = "axis-shared-half-split", cholesky = "axis-shared-threshold-float-cholesky";
  Json rows{
      row_of("made", 1000, "early", half, "ellipse", 2, 62),
      row_of("made", 1000, "early", cholesky, "ellipse", 3, 102),
      row_of("made", 1000, "early", half, "three-sigma-square", 4, 61),
      row_of("made", 1000, "standard", "per-pixel", "ellipse", 7, std::numeric_limits<double>::infinity()),
      row_of("made", 1000, "standard", "per-pixel", "opacity-box", 9, 102)};
  return file_of("swiftgs-bench", rows);
}

/// Rasterization takes time ~ n^0.8.
Json grown() {
  Json rows = Json::array();
  for (const double n : {1e5, 1e6, 4e6, 1.2e7})
    rows.push_back(row_of("grown", n, "early", "per-pixel", "ellipse", 1e-4 * std::pow(n, 0.8), 100));
  return file_of("swiftgs-bench", rows);
}

Json hard_frames() {
  Json file = file_of("swiftgs-stress", Json::array());
  for (const Json& error : {Json(2), Json(100), Json()})  // the last is infinite
    file["rows"].push_back({{"family", "needles"},
                            {"severity", 100},
                            {"severity_label", "how hard"},
                            {"width", 64},
                            {"height", 48},
                            {"renderer", "cpu/early/per-pixel/ellipse"},
                            {"backend", "cpu"},
                            {"sort", "early"},
                            {"raster", "per-pixel"},
                            {"bounds", "ellipse"},
                            {"seeds", 8},
                            {"failed", 0},
                            {"strict_normalised_error", error}});
  return file;
}

/// Whether the tool can make pages; if not the test is skipped.
bool has_vega() {
  if (!SWIFTGS_HAS_VEGA) skip("the tool was built without Vega (package libjs-vega)");
  return SWIFTGS_HAS_VEGA;
}

/// What tests/report/probe.js finds in the page, as a browser shows it.
Json shown_by(const TemporaryFolder& place, std::string html) {
  const std::size_t end_of_page = html.rfind("</body>");
  REQUIRE(end_of_page != html.npos);
  html.insert(end_of_page,
              "<script>{" + content_of(SWIFTGS_SOURCES "/tests/report/probe.js") + "}</script>\n");
  place.write("probed.html", html);
  const std::string folder = place.path().string();
  const std::string command =
      "timeout 120 '" SWIFTGS_BROWSER "' --headless --no-sandbox --disable-gpu --user-data-dir='" + folder +
      "/profile' --virtual-time-budget=30000 --window-size=1400,1200 --dump-dom 'file://" + folder +
      "/probed.html' >'" + folder + "/drawn.html' 2>'" + folder + "/browser.log'";
  const int status = std::system(command.c_str());
  CAPTURE(content_of(place / "browser.log"));
  REQUIRE(status == 0);
  const std::string drawn = content_of(place / "drawn.html"), begin = "<pre id=\"told\">";
  const std::size_t at = drawn.find(begin);
  REQUIRE_MESSAGE(at != drawn.npos, "the probe must reach its end");
  std::string json;
  for (std::size_t i = at + begin.size(); drawn[i] != '<'; ++i) {
    if (drawn[i] == '%') {
      json += char(std::stoi(drawn.substr(i + 1, 2), nullptr, 16));
      i += 2;
    } else {
      json += drawn[i];
    }
  }
  return Json::parse(json);
}

}  // namespace

TEST_CASE("report: a page draws what files hold and its figures are saved") {
  const TemporaryFolder place;
  if (!has_vega()) return;
  if (std::string(SWIFTGS_BROWSER).empty()) return skip("no Chromium here (package chromium)");
  place.write("compared.json", compared().dump());
  place.write("grown.json", grown().dump());
  place.write("stress.json", hard_frames().dump());
  const Outcome outcome =
      swiftgs::test::swiftgs(place, "report compared.json grown.json stress.json --out page.html");
  CAPTURE(outcome.err);
  REQUIRE(outcome.code == 0);
  const Json facts = shown_by(place, content_of(place / "page.html"));

  CHECK(facts["fault"] == "");
  CHECK(facts["asked"] == Json::array());
  CHECK(facts["missing"] == "");
  CHECK(facts["command"] == hostile);
  CHECK(facts["points"] == 5);
  CHECK(facts["infinite"] == true);
  CHECK(facts["front"] ==
        Json({"cpu/early/axis-shared-half-split/ellipse",
              "cpu/early/axis-shared-threshold-float-cholesky/ellipse", "cpu/standard/per-pixel/ellipse"}));
  CHECK(facts["segments"] == 15);
  CHECK(facts["speedups"] == Json({2.4, 2.0, 1.2}));  // 12 ms of the baseline over 5, 6 and 10
  check_holds(facts["growth"].dump(), {"project: exponent 0.00", "raster: exponent 0.80"});
  CHECK(facts["errors"] == 3);
  CHECK(facts["slowest"] == "cpu/standard/per-pixel/opacity-box");
  CHECK(facts["filtered"] == Json({"cpu/standard/per-pixel/ellipse"}));

  const std::string folder = place.path().string();
  const std::string command = "TMPDIR='" + folder +  // where the browser's profile is left
                              "' SWIFTGS_BROWSER='" SWIFTGS_BROWSER "' '" SWIFTGS_SOURCES
                              "/benchmarks/figures.sh' '" +
                              folder + "/page.html' '" + folder + "/figures' >'" + folder + "/listed.txt'";
  REQUIRE(std::system(command.c_str()) == 0);
  for (const std::string name :
       {"pareto-made", "stages-made", "speedup-made", "scaling-gaussians-grown", "stability-cpu"}) {
    const std::string svg = content_of(place / ("figures/" + name + ".svg"));
    CAPTURE(name);
    CHECK(svg.starts_with("<svg "));
    CHECK(svg.ends_with("</svg>"));
  }
}

TEST_CASE("report: files that are no results are refused and no results are replaced") {
  if (!has_vega()) return;
  const TemporaryFolder place;
  const Json good = grown();
  Json without_renderer = good, of_text = good, empty = good, newer = good;
  without_renderer["rows"][1].erase("renderer");
  of_text["rows"][0]["psnr_db"] = "high";
  empty["rows"] = Json::array();
  newer["version"] = 2;
  for (const auto& [content, said] : std::vector<std::pair<std::string, std::string>>{
           {"", "byte 0: expected JSON that goes on"},
           {"[1, 2, NaN]", "byte 7: expected JSON"},
           {std::string(100000, '['), "at most 16 deep"},
           {"[]", "format: expected \"swiftgs-bench\""},
           {newer.dump(), "version: expected 1, found 2"},
           {empty.dump(), "rows: expected at least one row"},
           {without_renderer.dump(), "rows[1].renderer: expected a text"},
           {of_text.dump(), "rows[0].psnr_db: expected a number or null"}}) {
    place.write("results.json", content);
    fails(place, "report results.json --out page.html", {"results.json", said});
    CHECK(!std::filesystem::exists(place / "page.html"));
  }
  place.write("results.json", good.dump());
  std::filesystem::create_symlink("results.json", place / "link.html");
  for (const std::string out : {"results.json", "link.html"}) {
    fails(place, "report results.json --out " + out,
          {"--out " + out + ": expected another file than that of RESULTS"});
    CHECK(content_of(place / "results.json") == good.dump());
  }
}
