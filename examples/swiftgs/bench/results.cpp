// SPDX-License-Identifier: Apache-2.0
#include "bench/results.hpp"

#include <cmath>

#include "draw/renderer_words.hpp"
#include "json_text.hpp"

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

}  // namespace swiftgs::cli
