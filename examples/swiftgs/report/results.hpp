// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

namespace swiftgs::cli {

/// The `format` of files that `swiftgs stress` writes.
inline constexpr const char* stress_format = "swiftgs-stress";

/// Reads a file that `swiftgs bench` or `swiftgs stress` wrote: every member that a reader counts on is
/// there and has its type, and there is at least one row.
///
/// Throws FormatError where it is not JSON, std::invalid_argument with file, member and what was expected
/// where it is something else, std::system_error where it cannot be read.
nlohmann::ordered_json read_results(const std::string& name);

}  // namespace swiftgs::cli
