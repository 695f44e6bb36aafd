// SPDX-License-Identifier: Apache-2.0
#include "bench/results.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <sstream>

#include <nlohmann/json.hpp>

#include <swiftgs/io/replace_file.hpp>

#include "renderer_words.hpp"

namespace swiftgs::cli {
namespace {

using Json = nlohmann::ordered_json;

/// `value` with as many digits as a measurement has; null where it is not finite.
Json rounded(double value, int digits = 6) {
  if (!std::isfinite(value)) return nullptr;
  char text[32];
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return std::strtod(text, nullptr);
}

Json named_or_null(const std::string& text) { return text.empty() ? Json() : Json(text); }

Json json_of(const Duration& d) {
  return {{"median", rounded(d.median)},
          {"low", rounded(d.low)},
          {"high", rounded(d.high)},
          {"p10", rounded(d.p10)},
          {"p90", rounded(d.p90)}};
}

Json json_of(const SceneResult& s) {
  return {{"scene", s.scene},     {"gaussians", s.gaussians}, {"original", s.original},
          {"enlarge", s.enlarge}, {"sh_degree", s.sh_degree}, {"antialiased", s.antialiased}};
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
  json["reference_image"] = named_or_null(v.reference_image);
  return json;
}

Json json_of(const RowResult& r) {
  Json json = json_of(r.place);
  json["threads"] = r.threads;
  json["renderer"] = r.renderer;
  const RendererWords words(r.renderer);
  json["backend"] = words.backend, json["sort"] = words.sort;
  json["raster"] = words.raster, json["bounds"] = words.bounds;
  json["frames"] = r.frames;
  json["calibrated"] = r.calibrated;
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
  json["visible"] = r.visible, json["instances"] = r.instances;
  json["contributing_pairs"] = r.contributing_pairs;
  json["bytes"] = {{"project", r.bytes.project}, {"sort", r.bytes.sort}, {"raster", r.bytes.raster}};
  json["device_bytes"] = r.device_bytes, json["host_bytes"] = r.host_bytes;
  json["image"] = named_or_null(r.image), json["error_image"] = named_or_null(r.error_image);
  return json;
}

Json json_of(const Machine& m) {
  Json json{{"date", m.date},
            {"cpu", m.cpu},
            {"cores", m.cores},
            {"memory_gib", m.memory_gib},
            {"system", m.system}};
  if (m.gpu)
    json.update(Json{{"gpu", m.gpu->name},
                     {"driver", m.gpu->driver},
                     {"cuda", m.gpu->cuda},
                     {"gpu_memory_gib", rounded(m.gpu->memory_gib, 4)}});
  json.update(Json{{"compiler", m.compiler},
                   {"flags", m.flags},
                   {"commit", m.commit},
                   {"version", m.version},
                   {"load", rounded(m.load, 3)}});
  return json;
}

std::string text_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

/// A member of an array, each element on a line of its own.
template <class Values>
void print(std::ostream& out, const char* name, const Values& values) {
  out << ",\n\"" << name << "\": [";
  const char* separator = "\n ";
  for (const auto& value : values) out << separator << text_of(json_of(value)), separator = ",\n ";
  out << "]";
}

}  // namespace

std::string to_json(const Machine& machine) { return text_of(json_of(machine)); }

void write_results(const Results& results, const std::filesystem::path& file) {
  std::ostringstream out;
  out << "{\"format\": \"swiftgs-bench\", \"version\": 1,\n\"machine\": " << to_json(results.machine)
      << ",\n\"command\": " << text_of(results.command);
  print(out, "scenes", results.scenes);
  print(out, "views", results.views);
  print(out, "rows", results.rows);
  out << "}\n";
  replace_file(file, out.str());
}

}  // namespace swiftgs::cli
