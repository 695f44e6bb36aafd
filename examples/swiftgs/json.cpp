// SPDX-License-Identifier: Apache-2.0
#include "json.hpp"

#include "json_text.hpp"

namespace swiftgs::cli {
namespace {

Json object_of(const StageTimes& ms) {
  return {{"project", ms.project}, {"sort", ms.sort}, {"raster", ms.raster}, {"total", ms.total}};
}

Json object_of(const CheckResult& result, bool with_photos) {
  Json json{{"renderer", result.renderer}, {"scene", result.scene},    {"view", result.view},
            {"width", result.width},       {"height", result.height},  {"ms", object_of(result.ms)},
            {"psnr_db", result.psnr_db},   {"max_abs", result.max_abs}};
  if (with_photos) json["photo_psnr_db"] = result.photo_psnr_db ? Json(*result.photo_psnr_db) : Json();
  return json;
}

Json object_of(const RenderResult& result) {
  Json json{{"renderer", result.renderer},
            {"scene", result.scene},
            {"view", result.view},
            {"width", result.width},
            {"height", result.height},
            {"scale", result.scale},
            {"conventions", result.conventions},
            {"lens", result.lens},
            {"batch", result.batch},
            {"image", result.image},
            {"ms", object_of(result.ms)}};
  if (!result.counts) return json;
  json["gaussians"] = result.counts->gaussians;
  json["visible"] = result.counts->visible;
  json["intersections"] = result.counts->intersections;
  json["contributing_pairs"] = result.counts->raster.contributing_pairs;
  json["pixels_stopped"] = result.counts->raster.pixels_stopped;
  return json;
}

}  // namespace

std::string to_json(const ResultHead& head, const std::vector<RenderResult>& results) {
  const auto row = [](const RenderResult& result) { return text_of(object_of(result)); };
  return document_of(head, {{"rows", array_of(results, row)}});
}

std::string to_json(const ResultHead& head, const std::vector<CheckResult>& results, bool with_photos) {
  const auto row = [&](const CheckResult& result) { return text_of(object_of(result, with_photos)); };
  return document_of(head, {{"rows", array_of(results, row)}});
}

}  // namespace swiftgs::cli
