// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstddef>

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

}  // namespace swiftgs
