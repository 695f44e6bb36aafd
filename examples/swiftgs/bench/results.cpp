// SPDX-License-Identifier: Apache-2.0

#include "bench/results.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <stdexcept>

#include "json.hpp"
#include "words.hpp"

namespace swiftgs::cli {
namespace {

Json json_of(const Duration& d) {
  return {{"median", rounded(d.median)},
          {"low", rounded(d.low)},
          {"high", rounded(d.high)},
          {"p10", rounded(d.p10)},
          {"p90", rounded(d.p90)}};
}

Json json_of(const SceneResult& s) {
  return {{"scene", s.scene},      {"gaussians", s.gaussians}, {"original", s.original},
          {"enlarge", s.enlarge},  {"sh_degree", s.sh_degree}, {"model", s.model},
          {"geometry", s.geometry}};
}

Json json_of(const Place& p) {
  return {
      {"scene", p.scene}, {"gaussians", p.gaussians}, {"enlarge", p.enlarge}, {"view", p.view},
      {"width", p.width}, {"height", p.height},       {"scale", p.scale},     {"conventions", p.conventions}};
}

void add_photo(Json& json, const std::optional<PhotoErrors>& photo) {
  json["photo_psnr_db"] = photo ? rounded(photo->psnr_db) : Json();
  json["photo_ssim"] = photo ? rounded(photo->ssim) : Json();
}

Json json_of(const ViewResult& v) {
  Json json = json_of(v.place);
  add_photo(json, v.photo);
  return json;
}

Json json_of(const RowResult& r) {
  Json json = json_of(r.place);
  json["threads"] = r.threads;
  json["renderer"] = r.renderer;
  const RendererWords words(r.renderer);
  json["backend"] = words.backend, json["sort"] = words.sort;
  json["raster"] = words.raster, json["bounds"] = words.bounds;
  json["planes"] = r.planes;
  json["harmonics"] = r.harmonics;
  json["frames"] = r.frames;
  json["batch"] = r.batch;
  json["ms"] = {{"project", json_of(r.ms.project)},
                {"sort", json_of(r.ms.sort)},
                {"raster", json_of(r.ms.raster)},
                {"total", json_of(r.ms.total)},
                {"wall", json_of(r.ms.wall)}};
  const Errors none{std::nan(""), std::nan(""), std::nan(""), std::nullopt};
  const Errors& errors = r.errors ? *r.errors : none;
  json["psnr_db"] = rounded(errors.psnr_db);
  json["ssim"] = rounded(errors.ssim, 9);  // of which what is short of 1 matters
  json["max_abs"] = rounded(errors.max_abs);
  json["cut_psnr_db"] = errors.cut_psnr_db ? rounded(*errors.cut_psnr_db) : Json();
  add_photo(json, r.photo);
  json["visible"] = r.visible, json["intersections"] = r.intersections;
  json["contributing_pairs"] = r.contributing_pairs;
  json["bytes"] = {{"project", r.bytes.project}, {"sort", r.bytes.sort}, {"raster", r.bytes.raster}};
  json["device_bytes"] = r.device_bytes, json["host_bytes"] = r.host_bytes;
  return json;
}

template <class Values>
Member array(const char* name, const Values& values) {
  return {name, array_of(values, [](const auto& value) { return text_of(json_of(value)); })};
}

}  // namespace

std::string to_json(const Results& results) {
  return document_of(results.head, {array("scenes", results.scenes), array("views", results.views),
                                    array("rows", results.rows)});
}

namespace {

/// What makes two times comparable. The date and the load may change.
constexpr const char* same_machine[] = {"cpu",      "cores", "system", "gpu",     "driver",
                                        "compiler", "flags", "cuda",   "version", "commit"};

[[noreturn]] void fail(const std::string& path, const std::string& what) {
  throw std::runtime_error("--resume " + path + ": " + what);
}

/// A number that `rounded` has written.
double number(const Json& json) {
  return json.is_null() ? std::numeric_limits<double>::quiet_NaN() : json.get<double>();
}

Duration duration_of(const Json& json) {
  return {json.at("median"), json.at("low"), json.at("high"), json.at("p10"), json.at("p90")};
}

Place place_of(const Json& json) {
  return {json.at("scene"), json.at("gaussians"), json.at("enlarge"), json.at("view"),
          json.at("width"), json.at("height"),    json.at("scale"),   json.at("conventions")};
}

std::optional<PhotoErrors> photo_of(const Json& json) {
  if (json.at("photo_psnr_db").is_null()) return std::nullopt;
  return PhotoErrors{json.at("photo_psnr_db"), number(json.at("photo_ssim"))};
}

/// The PSNR of equal images is infinite, and null in the file, as are all errors where there are none.
std::optional<Errors> errors_of(const Json& json) {
  if (json.at("max_abs").is_null()) return std::nullopt;
  const Json &psnr = json.at("psnr_db"), &cut = json.at("cut_psnr_db");
  return Errors{psnr.is_null() ? std::numeric_limits<double>::infinity() : psnr.get<double>(),
                number(json.at("ssim")), json.at("max_abs"),
                cut.is_null() ? std::nullopt : std::optional(cut.get<double>())};
}

SceneResult scene_of(const Json& json) {
  return {json.at("scene"),     json.at("gaussians"), json.at("original"), json.at("enlarge"),
          json.at("sh_degree"), json.at("model"),     json.at("geometry")};
}

ViewResult view_of(const Json& json) { return {place_of(json), photo_of(json)}; }

RowResult row_of(const Json& json) {
  RowResult row;
  row.place = place_of(json);
  row.threads = json.at("threads");
  row.renderer = json.at("renderer"), row.planes = json.at("planes"), row.harmonics = json.at("harmonics");
  row.frames = json.at("frames"), row.batch = json.at("batch");
  const Json& ms = json.at("ms");
  row.ms = {duration_of(ms.at("project")), duration_of(ms.at("sort")), duration_of(ms.at("raster")),
            duration_of(ms.at("total")), duration_of(ms.at("wall"))};
  row.errors = errors_of(json), row.photo = photo_of(json);
  row.visible = json.at("visible"), row.intersections = json.at("intersections");
  row.contributing_pairs = json.at("contributing_pairs");
  const Json& bytes = json.at("bytes");
  row.bytes = {bytes.at("project"), bytes.at("sort"), bytes.at("raster")};
  row.device_bytes = json.at("device_bytes"), row.host_bytes = json.at("host_bytes");
  return row;
}

void require_same(const std::string& path, const std::string& what, const Json& found, const Json& here) {
  if (found != here) fail(path, what + " is " + text_of(found) + "; expected " + text_of(here));
}

}  // namespace

Results resumed_results(const std::string& path, const ResultHead& head) {
  Results results{.head = head, .scenes = {}, .views = {}, .rows = {}};
  std::ifstream in(path, std::ios::binary);
  if (!in && !std::filesystem::exists(path)) return results;
  try {
    const Json found = Json::parse(in), here = Json::parse(document_of(head, {}));
    for (const char* member : {"format", "version", "command"})
      require_same(path, member, found.at(member), here.at(member));
    for (const char* member : same_machine)
      require_same(path, std::string("machine.") + member, found.at("machine").value(member, Json()),
                   here.at("machine").value(member, Json()));
    for (const Json& scene : found.at("scenes")) results.scenes.push_back(scene_of(scene));
    for (const Json& view : found.at("views")) results.views.push_back(view_of(view));
    for (const Json& row : found.at("rows")) results.rows.push_back(row_of(row));
  } catch (const Json::exception& error) {
    fail(path, std::string("expected what bench has written; ") + error.what());
  }
  return results;
}

void require_same_scene(const std::string& path, const Results& found, const SceneResult& scene) {
  for (const SceneResult& other : found.scenes)
    if (other.scene == scene.scene && other.gaussians == scene.gaussians && other.enlarge == scene.enlarge &&
        (other.geometry != scene.geometry || other.model != scene.model))
      fail(path, "scene " + scene.scene +
                     " has changed; expected the Gaussians and the model that the file was measured with");
}

}  // namespace swiftgs::cli
