// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <string_view>

namespace swiftgs {

/// Types to combine.
template <class... Types>
struct TypeList {
  static constexpr std::size_t size = sizeof...(Types);
  template <class T>
  static constexpr bool contains = (std::same_as<T, Types> || ...);
};

/// Calls `f` with one object of each type, in the order of the list.
template <class... Types, class F>
void for_each_type(TypeList<Types...>, const F& f) {
  (f(Types()), ...);
}

/// A name put together at compile time from the names of policies.
class ComposedName {
 public:
  template <class... Parts>
  constexpr explicit ComposedName(Parts... parts) {
    (append(std::string_view(parts)), ...);
  }
  constexpr std::string_view view() const { return {text_.data(), size_}; }

 private:
  constexpr void append(std::string_view part) {
    for (const char c : part) text_.at(size_++) = c;
  }
  std::array<char, 128> text_{};
  std::size_t size_ = 0;
};

}  // namespace swiftgs
