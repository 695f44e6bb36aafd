// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <charconv>
#include <cstddef>
#include <string_view>

namespace swiftgs::io {

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
