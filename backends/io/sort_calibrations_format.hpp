// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include <swiftgs/io/sort_calibrations.hpp>

namespace swiftgs::io {

inline constexpr std::string_view sort_calibrations_format = "swiftgs-sort-calibrations";
inline constexpr int sort_calibrations_version = 1;

}  // namespace swiftgs::io
