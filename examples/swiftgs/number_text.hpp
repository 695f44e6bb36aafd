// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <charconv>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

/// @file
/// Numbers as users type them.

namespace swiftgs::cli {

/// A number as the user may have typed it, for messages.
inline std::string text_of_number(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", number);
  return text;
}

/// What stands between separators; one part, maybe empty, where there are none.
inline std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (std::size_t at = 0; at != std::string_view::npos;) {
    const std::size_t next = text.find(separator);
    parts.push_back(text.substr(0, next));
    at = next;
    if (next != std::string_view::npos) text.remove_prefix(next + 1);
  }
  return parts;
}

/// The number that all of `text` is, or nothing.
template <class Number>
std::optional<Number> parse(std::string_view text) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

}  // namespace swiftgs::cli
