// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string_view>

namespace swiftgs::io {

/// Whether a file's name ends in `ending`, in letters of either case: `OUT.PLY` in `.ply`.
inline bool has_ending(std::string_view name, std::string_view ending) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c; };
  return name.size() >= ending.size() && std::equal(ending.rbegin(), ending.rend(), name.rbegin(),
                                                    [&](char a, char b) { return lower(a) == lower(b); });
}

}  // namespace swiftgs::io
