// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string_view>

namespace swiftgs::cli {

/// The content of a file that was compiled into the tool, by its name without a folder; empty where there is
/// none of that name, as with the modules of Vega when it was not there at build time.
std::string_view embedded(std::string_view name);

}  // namespace swiftgs::cli
