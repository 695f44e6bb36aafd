// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>

#include "bytes.hpp"

/// @file
/// What may stand before the first character of a text. All readers of texts skip it by these functions.

namespace swiftgs::io {

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

}  // namespace swiftgs::io
