// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace swiftgs::cli {

/// How many characters are to be added, left out, replaced or swapped with their neighbour to make one word
/// of the other.
std::size_t edits_between(std::string_view a, std::string_view b);

/// ", did you mean 'NEAREST'?" if one of `known` is near `word`; otherwise nothing.
std::string suggestion(std::string_view word, const std::vector<std::string>& known);

}  // namespace swiftgs::cli
