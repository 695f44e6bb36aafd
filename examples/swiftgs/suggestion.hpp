// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace swiftgs::cli {

/// ", did you mean 'NEAREST'?" if one of `known` is near `word`; otherwise nothing.
std::string suggestion(std::string_view word, const std::vector<std::string>& known);

}  // namespace swiftgs::cli
