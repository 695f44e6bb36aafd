// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Words of the command line: numbers as users type them, words for a shell, names of renderers.

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

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

/// `text` as a POSIX shell reads it as one word: in single quotes where it is empty or has a character that
/// may mean something to a shell.
inline std::string shell_word(std::string_view text) {
  constexpr std::string_view plain =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_./:=,@%+-";
  if (!text.empty() && text.find_first_not_of(plain) == std::string_view::npos) return std::string(text);
  std::string quoted = "'";
  for (const char c : text)
    if (c == '\'')
      quoted += "'\\''";
    else
      quoted += c;
  return quoted + "'";
}

/// A renderer's name, BACKEND/SORT/RASTER/BOUNDS, word by word.
struct RendererWords {
  std::string backend, sort, raster, bounds;

  explicit RendererWords(std::string_view name) {
    for (std::string* word : {&backend, &sort, &raster, &bounds}) {
      const std::size_t length = std::min(name.find('/'), name.size());
      *word = name.substr(0, length);
      name.remove_prefix(std::min(length + 1, name.size()));
    }
  }

  std::string name() const { return backend + "/" + sort + "/" + raster + "/" + bounds; }
};

}  // namespace swiftgs::cli
