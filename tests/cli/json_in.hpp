// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include <nlohmann/json.hpp>

#include "support/files.hpp"

namespace swiftgs::test {

/// What a command wrote to `file`.
inline nlohmann::json json_in(const std::filesystem::path& file) {
  return nlohmann::json::parse(content_of(file));
}

}  // namespace swiftgs::test
