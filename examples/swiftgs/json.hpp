// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include <nlohmann/json.hpp>

#include <swiftgs/drivers/statistics.hpp>

#include "result_head.hpp"

namespace swiftgs::cli {

using Json = nlohmann::ordered_json;

/// UTF-8 or not: a name from a file may hold any bytes. What is not finite becomes null.
inline std::string text_of(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// `value` with as many digits as a measurement has; null where it is not finite.
inline Json rounded(double value, int digits = 6) {
  if (!std::isfinite(value)) return nullptr;
  char text[32];
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return std::strtod(text, nullptr);
}

/// The members of an object, as `document_of` takes them.
inline std::vector<Member> members_of(const Json& object) {
  std::vector<Member> members;
  for (const auto& [name, value] : object.items()) members.emplace_back(name, text_of(value));
  return members;
}

/// One frame of `check`, against the reference.
struct CheckResult {
  std::string renderer, scene, view;
  int width = 0, height = 0;
  StageTimes ms;
  double psnr_db = 0, max_abs = 0;
  std::optional<double> photo_psnr_db;  ///< against the photograph, where there is one

  static auto members(auto& self) {
    return std::tie(self.renderer, self.scene, self.view, self.width, self.height, self.ms, self.psnr_db,
                    self.max_abs, self.photo_psnr_db);
  }
};

/// One image of `render`.
struct RenderResult {
  std::string renderer, scene, view, conventions;
  std::string lens;  ///< as `words_of` says it
  int width = 0, height = 0;
  double scale = 1;
  std::size_t batch = 1;  ///< views of the frame that it is of; `ms` are its durations over their number
  std::string image;      ///< the file's name as the command prints it
  StageTimes ms;
  std::optional<Statistics> counts;  ///< where they were asked for

  static auto members(auto& self) {
    return std::tie(self.renderer, self.scene, self.view, self.conventions, self.lens, self.width,
                    self.height, self.scale, self.batch, self.image, self.ms, self.counts);
  }
};

/// The document of `render --json`.
std::string to_json(const ResultHead& head, const std::vector<RenderResult>& results);

/// The document of `check --json`. `photo_psnr_db` is a member of every object if `with_photos`, null where
/// there is no photograph.
std::string to_json(const ResultHead& head, const std::vector<CheckResult>& results, bool with_photos);

}  // namespace swiftgs::cli
