// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace swiftgs::test {

using Json = nlohmann::json;

/// A row of a result file, of what tests vary.
struct Row {
  std::string renderer = "cpu/early/per-pixel/ellipse";
  double project = 1, sort = 2, raster = 3;  ///< milliseconds
  double psnr_db = 100;  ///< infinite where nothing differs, NaN where nothing was measured
  std::string scene = "made", view = "front";
  double gaussians = 1000, enlarge = 1, scale = 1, threads = 4;
  int width = 640, height = 480;
  double intersections = 5000, bytes = 1e6;
  std::vector<double> stage_bytes{};  ///< of project, sort and raster; older files have none
};

inline Json duration(double ms) {
  return {{"median", ms}, {"low", 0.99 * ms}, {"high", 1.02 * ms}, {"p10", 0.98 * ms}, {"p90", 1.05 * ms}};
}

inline Json json_of(const Row& row) {
  std::vector<std::string> words(1);
  for (const char c : row.renderer) {
    if (c == '/')
      words.emplace_back();
    else
      words.back() += c;
  }
  const double total = row.project + row.sort + row.raster;
  const bool measured = !std::isnan(row.psnr_db), differs = std::isfinite(row.psnr_db);
  Json json{{"scene", row.scene},
            {"gaussians", row.gaussians},
            {"enlarge", row.enlarge},
            {"view", row.view},
            {"width", row.width},
            {"height", row.height},
            {"scale", row.scale},
            {"conventions", "gsplat"},
            {"threads", row.threads},
            {"renderer", row.renderer},
            {"backend", words.at(0)},
            {"sort", words.at(1)},
            {"raster", words.at(2)},
            {"bounds", words.at(3)},
            {"frames", 20},
            {"ms",
             {{"project", duration(row.project)},
              {"sort", duration(row.sort)},
              {"raster", duration(row.raster)},
              {"total", duration(total)},
              {"wall", duration(1.1 * total)}}},
            {"psnr_db", measured && differs ? Json(row.psnr_db) : Json()},
            {"ssim", measured ? Json(0.999) : Json()},
            {"max_abs", measured ? Json(differs ? 4 * std::pow(10, -row.psnr_db / 20) : 0) : Json()},
            {"photo_psnr_db", nullptr},
            {"photo_ssim", nullptr},
            {"visible", 700},
            {"intersections", row.intersections},
            {"contributing_pairs", 40000},
            {"device_bytes", 0},
            {"host_bytes", row.bytes}};
  const char* stage[] = {"project", "sort", "raster"};
  for (std::size_t i = 0; i < row.stage_bytes.size(); ++i) json["bytes"][stage[i]] = row.stage_bytes[i];
  return json;
}

/// A result file of rows that were never measured.
inline Json results_of(const std::vector<Row>& rows) {
  Json results{{"format", "swiftgs-bench"},
               {"version", 1},
               {"machine",
                {{"date", "2026-01-02"},
                 {"cpu", "A processor"},
                 {"cores", 4},
                 {"memory_gib", 8},
                 {"commit", "0123+"}}},
               {"command", "swiftgs bench made"},
               {"scenes", Json::array()},
               {"views", Json::array()},
               {"rows", Json::array()}};
  for (const Row& row : rows) {
    Json json = json_of(row);
    Json scene, view;
    for (const char* name : {"scene", "gaussians", "enlarge"}) scene[name] = view[name] = json[name];
    scene["original"] = rows.front().gaussians;
    for (const char* name : {"view", "width", "height", "scale", "conventions"}) view[name] = json[name];
    results["scenes"].push_back(scene);
    results["views"].push_back(view);
    results["rows"].push_back(json);
  }
  return results;
}

/// A row of `swiftgs stress`, of what tests vary. What is not finite becomes null.
struct StressRow {
  std::string family = "needles";
  double severity = 100, ratio = 2, max_abs = 1e-6;
  std::string backend = "cpu", raster = "per-pixel";
  int failed = 0;
};

inline Json stress_results_of(const std::vector<StressRow>& rows) {
  Json results = results_of({{}});
  results["format"] = "swiftgs-stress", results["command"] = "swiftgs stress made";
  results.erase("scenes"), results.erase("views");
  results["rows"] = Json::array();
  for (const StressRow& row : rows)
    results["rows"].push_back({{"family", row.family},
                               {"severity", row.severity},
                               {"severity_label", "how hard"},
                               {"width", 64},
                               {"height", 48},
                               {"renderer", row.backend + "/early/" + row.raster + "/ellipse"},
                               {"backend", row.backend},
                               {"sort", "early"},
                               {"raster", row.raster},
                               {"bounds", "ellipse"},
                               {"seeds", 8},
                               {"failed", row.failed},
                               {"error", row.failed ? Json("seed 1: no <memory>") : Json()},
                               {"strict_normalised_error", row.ratio},
                               {"normalised_error", row.ratio},
                               {"normalised_depth_error", row.ratio},
                               {"psnr_db", 120},
                               {"max_abs", row.max_abs},
                               {"flips", 0},
                               {"ambiguity", 0.5},
                               {"worst_seed", 3},
                               {"worst_pixel", 17}});
  return Json::parse(results.dump());
}

}  // namespace swiftgs::test
