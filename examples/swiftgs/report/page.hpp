// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace swiftgs::cli {

/// Whether the plotting library was there when the tool was built.
bool can_plot();

/// One HTML page that asks for nothing outside: style, scripts, the plotting library with its licence, and
/// `data`, JSON in ASCII, which the scripts draw.
std::string page_of(std::string_view data);

}  // namespace swiftgs::cli
