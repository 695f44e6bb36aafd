// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

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

}  // namespace swiftgs::cli
