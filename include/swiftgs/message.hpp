// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstddef>
#include <string>
#include <string_view>

#include <swiftgs/error.hpp>

namespace swiftgs::detail {

/// Text or a number within a message. It does not copy the text.
class MessagePart {
 public:
  MessagePart(const char* text) : text_(text) {}
  MessagePart(std::string_view text) : text_(text) {}
  template <std::same_as<std::string> S>  // nothing that converts to one
  MessagePart(const S& text) : text_(text) {}
  MessagePart(char) = delete;  // a letter or a number
  template <std::signed_integral N>
  MessagePart(N number) : kind_(Kind::integer), integer_(number) {}
  template <std::unsigned_integral N>
  MessagePart(N number) : kind_(Kind::natural), natural_(number) {}
  template <std::floating_point N>
  MessagePart(N number) : kind_(Kind::real), real_(double(number)) {}

  void append_to(std::string& message) const {
    if (kind_ == Kind::text) message.append(text_);
    if (kind_ == Kind::integer) message.append(std::to_string(integer_));
    if (kind_ == Kind::natural) message.append(std::to_string(natural_));
    if (kind_ == Kind::real) message.append(std::to_string(real_));
  }

 private:
  enum class Kind { text, integer, natural, real } kind_ = Kind::text;
  std::string_view text_{};
  union {
    long long integer_ = 0;
    unsigned long long natural_;
    double real_;
  };
};

inline std::string joined(const MessagePart* parts, std::size_t count) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i) parts[i].append_to(text);
  return text;
}

/// Concatenates `parts`. Takes copies so that few instances are compiled. A sum of strings is
/// several times as much code wherever a function throws.
template <class... Parts>
std::string message(Parts... parts) {
  const MessagePart all[] = {MessagePart(parts)...};
  return joined(all, sizeof...(parts));
}

/// Throws `InvalidArgument` with the message of `parts`.
template <class... Parts>
[[noreturn]] void refuse(Parts... parts) {
  throw InvalidArgument(message(parts...));
}

}  // namespace swiftgs::detail
