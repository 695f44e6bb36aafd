// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>

namespace swiftgs {

/// Types to combine.
template <class... Types>
struct TypeList {
  template <class T>
  static constexpr bool contains = (std::same_as<T, Types> || ...);
};

/// Calls f(T()) for every type of the list.
template <class... Types, class F>
constexpr void for_each_type(TypeList<Types...>, const F& f) {
  (f(Types()), ...);
}

}  // namespace swiftgs
