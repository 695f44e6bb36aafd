// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string_view>

namespace swiftgs::io {

/// Whether a file's name ends in `ending`, such as `.ply`, in letters of either case.
inline bool has_ending(std::string_view name, std::string_view ending) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c; };
  return name.size() >= ending.size() &&
         std::equal(ending.begin(), ending.end(), name.end() - std::ptrdiff_t(ending.size()),
                    [&](char a, char b) { return lower(a) == lower(b); });
}

}  // namespace swiftgs::io
