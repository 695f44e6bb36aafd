// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string_view>

namespace swiftgs::io {

/// Whether `name` ends in `ending`, be it in upper or lower case: `OUT.PLY` in `.ply`.
inline bool ends_with_ignoring_case(std::string_view name, std::string_view ending) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c; };
  return name.size() >= ending.size() && std::equal(ending.rbegin(), ending.rend(), name.rbegin(),
                                                    [&](char a, char b) { return lower(a) == lower(b); });
}

}  // namespace swiftgs::io
