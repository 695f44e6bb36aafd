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

}  // namespace swiftgs
