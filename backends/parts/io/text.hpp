// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Texts that are read, by marks and words, and lists of names in messages.

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "bytes.hpp"

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

/// Whether a file's name ends in `ending`, in letters of either case: `OUT.PLY` in `.ply`.
inline bool has_ending(std::string_view name, std::string_view ending) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c; };
  return name.size() >= ending.size() && std::equal(ending.rbegin(), ending.rend(), name.rbegin(),
                                                    [&](char a, char b) { return lower(a) == lower(b); });
}

/// Bytes of UTF-8's byte order mark, which editors of Windows write at the beginning of a text: 3 or 0.
inline std::size_t mark_bytes(std::string_view text) { return text.starts_with("\xef\xbb\xbf") ? 3 : 0; }

/// Where JSON starts in `text`, behind a mark and blanks; its size if nothing follows.
inline std::size_t json_start(std::string_view text) {
  return std::min(text.find_first_not_of(" \t\r\n", mark_bytes(text)), text.size());
}

/// "UTF-16" or "UTF-32" if `text` begins as a text in that encoding, else empty. Programs of Windows write
/// such texts, with a byte order mark or without.
inline std::string_view other_encoding(std::string_view text) {
  using namespace std::literals;
  if (text.starts_with("\xff\xfe\0\0"sv) || text.starts_with("\0\0\xfe\xff"sv)) return "UTF-32";
  if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff")) return "UTF-16";
  const auto is_ascii = [](char c) { return c == '\t' || c == '\n' || c == '\r' || (c >= ' ' && c <= '~'); };
  if (text.size() < 4) return {};
  const bool little = is_ascii(text[0]) && text[1] == 0 && is_ascii(text[2]) && text[3] == 0;
  const bool big = text[0] == 0 && is_ascii(text[1]) && text[2] == 0 && is_ascii(text[3]);
  return little || big ? "UTF-16" : "";
}

/// Throws `FormatError` for a text in UTF-16 or UTF-32.
inline void expect_utf8(const Source& source) {
  if (const std::string_view other = other_encoding(source.text()); !other.empty())
    source.fail(0, std::string("a text in UTF-8, found one in ").append(other));
}

/// Whether a text begins with a comment, as some editors let JSON begin.
inline bool begins_with_comment(std::string_view text) {
  const std::string_view words = text.substr(json_start(text));
  return words.starts_with("//") || words.starts_with("/*");
}

/// Words of a text that blanks separate; line breaks are blanks too.
class Tokens {
 public:
  explicit Tokens(std::string_view text, std::size_t position = 0) : text_(text), position_(position) {}

  /// The next word; empty at the end.
  std::string_view next() {
    skip_blanks();
    const std::size_t begin = position_;
    while (position_ < text_.size() && !is_blank(text_[position_])) ++position_;
    return text_.substr(begin, position_ - begin);
  }

  /// What follows the last word read, without blanks around it.
  std::string_view rest() {
    skip_blanks();
    std::string_view rest = text_.substr(position_);
    while (!rest.empty() && is_blank(rest.back())) rest.remove_suffix(1);
    return rest;
  }

  bool at_end() {
    skip_blanks();
    return position_ == text_.size();
  }

  std::size_t position() const { return position_; }

 private:
  static bool is_blank(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

  void skip_blanks() {
    while (position_ < text_.size() && is_blank(text_[position_])) ++position_;
  }

  std::string_view text_;
  std::size_t position_;
};

/// Whether all of `word` is one number within T's range, in C's spelling whatever the locale is.
template <class T>
bool to_number(std::string_view word, T& value) {
  if (word.starts_with('+')) {
    word.remove_prefix(1);
    if (word.starts_with('-')) return false;
  }
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, value);
  return error == std::errc() && stop == end;
}

}  // namespace swiftgs::io
