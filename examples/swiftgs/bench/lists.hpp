// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace swiftgs::cli {

/// The parts of `text` between commas. Throws `InvalidArgument`, naming `option`, for an empty one and
/// for one that is there twice.
std::vector<std::string> list_of(const std::string& option, const std::string& text);

/// The same as numbers.
std::vector<double> numbers_of(const std::string& option, const std::string& text);
std::vector<std::size_t> counts_of(const std::string& option, const std::string& text);

}  // namespace swiftgs::cli
