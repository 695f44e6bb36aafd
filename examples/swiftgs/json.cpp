// SPDX-License-Identifier: Apache-2.0

#include "json.hpp"

#include "result_head.hpp"

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

namespace {

constexpr int version_of_formats = 1;

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

}  // namespace

ResultHead head_of(std::string_view format) {
  return {.format = std::string(format), .machine = describe_machine(), .command = command_line()};
}

std::string document_of(const ResultHead& head, const std::vector<Member>& members) {
  std::string text =
      "{\"format\": " + text_of(head.format) + ", \"version\": " + std::to_string(version_of_formats) +
      ",\n\"machine\": " + text_of(json_of(head.machine)) + ",\n\"command\": " + text_of(head.command) +
      ",\n\"notes\": " + text_of(Json(head.notes));
  for (const auto& [name, value] : members) text += ",\n\"" + name + "\": " + value;
  return text + "}\n";
}

std::string array_of(const std::vector<std::string>& elements) {
  std::string text = "[";
  for (const std::string& element : elements) text += (text.size() > 1 ? ",\n " : "\n ") + element;
  return text + "]";
}

}  // namespace swiftgs::cli
