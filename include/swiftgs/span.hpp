// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstddef>

#include <swiftgs/math.hpp>

namespace swiftgs {

/// Pointer and length. Unlike `std::span`, indexing is callable from device code without extra compiler
/// flags.
template <class T>
struct Span {
  T* data = nullptr;
  std::size_t size = 0;

  SWIFTGS_HD constexpr T& operator[](std::size_t i) const { return data[i]; }
  SWIFTGS_HD constexpr T* begin() const { return data; }
  SWIFTGS_HD constexpr T* end() const { return data + size; }
  SWIFTGS_HD constexpr bool empty() const { return size == 0; }
  SWIFTGS_HD constexpr Span first(std::size_t count) const { return {data, count}; }

  /// A view of mutable elements is also a view of constant ones.
  template <std::same_as<const T> U>
  SWIFTGS_HD constexpr operator Span<U>() const {
    return {data, size};
  }
};

template <class T>
Span(T*, std::size_t) -> Span<T>;

}  // namespace swiftgs
