// SPDX-License-Identifier: Apache-2.0
#include "stress/results.hpp"

#include "json_text.hpp"
#include "draw/renderer_words.hpp"

namespace swiftgs::cli {
namespace {

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
  number("strict_normalised_error", r.strict_normalised_error),
      number("normalised_error", r.normalised_error),
      number("normalised_depth_error", r.normalised_depth_error);
  number("psnr_db", r.psnr_db), number("max_abs", r.max_abs);
  number("flips", r.flips), number("ambiguity", r.ambiguity), number("allowed", r.allowed),
      number("judged", r.judged);
  number("worst_seed", r.worst_seed), number("worst_pixel", r.worst_pixel);
  return json;
}

}  // namespace

std::string to_json(const StressResults& results) {
  return document_of(
      results.head,
      {{"rows", array_of(results.rows, [](const StressRow& row) { return text_of(json_of(row)); })}});
}

}  // namespace swiftgs::cli
