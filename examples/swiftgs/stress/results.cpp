// SPDX-License-Identifier: Apache-2.0
#include "stress/results.hpp"

#include <nlohmann/json.hpp>

#include "bench/results.hpp"
#include "renderer_words.hpp"

namespace swiftgs::cli {
namespace {

using Json = nlohmann::ordered_json;

/// UTF-8 or not: a message may hold any bytes. What is not finite becomes null.
std::string text_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

Json json_of(const StressRow& r) {
  const RendererWords words(r.renderer);
  Json json{{"family", r.family},
            {"severity", r.severity},
            {"severity_label", r.severity_label},
            {"width", r.width},
            {"height", r.height},
            {"renderer", r.renderer},
            {"backend", words.backend},
            {"sort", words.sort},
            {"raster", words.raster},
            {"bounds", words.bounds},
            {"seeds", r.seeds},
            {"failed", r.failed},
            {"error", r.error.empty() ? Json() : Json(r.error)}};
  const bool drawn = r.failed < r.seeds;
  const auto number = [&](const char* name, const auto& value) { json[name] = drawn ? Json(value) : Json(); };
  number("ratio", r.ratio), number("excess", r.excess), number("depth_excess", r.depth_excess);
  number("psnr_db", r.psnr_db), number("max_abs", r.max_abs);
  number("flips", r.flips), number("loosest", r.loosest), number("judged", r.judged);
  number("worst_seed", r.worst_seed), number("worst_pixel", r.worst_pixel);
  return json;
}

}  // namespace

std::string to_json(const StressResults& results) {
  std::string text =
      "{\"format\": \"swiftgs-stress\", \"version\": 1,\n\"machine\": " + to_json(results.machine) +
      ",\n\"command\": " + text_of(results.command) + ",\n\"rows\": [";
  for (const StressRow& row : results.rows)
    text += (&row == results.rows.data() ? "\n " : ",\n ") + text_of(json_of(row));
  return text + "]}\n";
}

}  // namespace swiftgs::cli
