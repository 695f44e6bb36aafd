// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

namespace swiftgs::io {

/// The first of `names`, in one line. Long ones are cut, and characters other than printable ASCII become
/// '?'.
inline std::string listed(const std::vector<std::string>& names, const std::string& separator = ", ") {
  constexpr std::size_t most = 12, longest = 40;
  std::string list;
  for (std::size_t i = 0; i < std::min(most, names.size()); ++i) {
    std::string name = names[i].substr(0, longest);
    for (char& c : name)
      if (c < ' ' || c > '~') c = '?';
    list += (i == 0 ? "" : separator) + name + (names[i].size() > longest ? "..." : "");
  }
  if (names.size() > most) list += " and " + std::to_string(names.size() - most) + " more";
  return list;
}

/// "a, b or c".
inline std::string either(const std::vector<std::string>& names) {
  std::string list;
  for (std::size_t i = 0; i < names.size(); ++i)
    list += (i == 0 ? "" : i + 1 < names.size() ? ", " : " or ") + names[i];
  return list;
}

}  // namespace swiftgs::io
