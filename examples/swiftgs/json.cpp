// SPDX-License-Identifier: Apache-2.0
#include "json.hpp"

#include <nlohmann/json.hpp>

namespace swiftgs::cli {
namespace {

using Json = nlohmann::ordered_json;

/// UTF-8 or not: a name from a file may hold any bytes.
std::string text_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

Json object_of(const CheckResult& result, bool with_photos) {
  Json json{{"renderer", result.renderer},
            {"scene", result.scene},
            {"view", result.view},
            {"width", result.width},
            {"height", result.height},
            {"ms",
             {{"project", result.ms.project},
              {"sort", result.ms.sort},
              {"raster", result.ms.raster},
              {"total", result.ms.total}}},
            {"psnr_db", result.psnr_db},
            {"max_abs", result.max_abs}};
  if (with_photos) json["photo_psnr_db"] = result.photo_psnr_db ? Json(*result.photo_psnr_db) : Json();
  return json;
}

}  // namespace

std::string to_json(const Comparison& comparison) {
  return text_of(
      {{"psnr_db", comparison.psnr_db}, {"ssim", comparison.ssim}, {"max_abs", comparison.max_abs}});
}

std::string to_json(const std::vector<CheckResult>& results, bool with_photos) {
  std::string text = "[";
  for (const CheckResult& result : results)
    text += (text.size() > 1 ? ",\n " : "\n ") + text_of(object_of(result, with_photos));
  return text + "\n]\n";
}

}  // namespace swiftgs::cli
