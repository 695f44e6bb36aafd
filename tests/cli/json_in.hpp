// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <set>
#include <string>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "support/files.hpp"

namespace swiftgs::test {

using nlohmann::json;

/// What a command wrote to `file`.
inline json json_in(const std::filesystem::path& file) { return json::parse(content_of(file)); }

inline std::set<std::string> members_of(const json& object) {
  std::set<std::string> members;
  for (const auto& item : object.items()) members.insert(item.key());
  return members;
}

/// Checks that `object` has the members of the JSON `expected` with their values.
inline void check_members(const json& object, const std::string& expected) {
  const auto members = json::parse(expected);
  for (const auto& member : members.items()) {
    CAPTURE(member.key());
    CHECK(object.at(member.key()) == member.value());
  }
}

}  // namespace swiftgs::test
