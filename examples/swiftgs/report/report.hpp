// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

namespace swiftgs::cli {

/// Whether the plotting library was there when the tool was built.
bool can_plot();

/// One HTML page that asks for nothing outside: style, scripts, the plotting library with its licence, and
/// `data`, JSON in ASCII, which the scripts draw.
std::string page_of(std::string_view data);

/// The `format` of files that `swiftgs stress` writes.
inline constexpr const char* stress_format = "swiftgs-stress";

/// Reads a file that `swiftgs bench` or `swiftgs stress` wrote: every member that a reader counts on is
/// there and has its type, and there is at least one row.
///
/// Throws FormatError where it is not JSON, std::invalid_argument with file, member and what was expected
/// where it is something else, std::system_error where it cannot be read.
nlohmann::ordered_json read_results(const std::string& name);

}  // namespace swiftgs::cli
