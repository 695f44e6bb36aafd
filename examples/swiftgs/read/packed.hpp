// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <vector>

/// Rows as bytes, for other processes of the same build: plain data as it lies in memory, strings and vectors
/// behind their lengths. A struct of these lists them by a static function `members`.
namespace swiftgs::cli {

template <class T>
void pack(std::string& to, const T& value) {
  if constexpr (std::is_trivially_copyable_v<T>) {
    to.append(reinterpret_cast<const char*>(&value), sizeof value);
  } else if constexpr (requires { T::members(value); }) {
    std::apply([&](const auto&... members) { (pack(to, members), ...); }, T::members(value));
  } else {
    pack(to, std::size_t(value.size()));
    for (const auto& element : value) pack(to, element);
  }
}

template <class T>
void unpack(std::string_view& from, T& value) {
  if constexpr (std::is_trivially_copyable_v<T>) {
    if (from.size() < sizeof value) throw std::logic_error("unpack: expected more bytes of a row");
    std::memcpy(&value, from.data(), sizeof value);
    from.remove_prefix(sizeof value);
  } else if constexpr (requires { T::members(value); }) {
    std::apply([&](auto&... members) { (unpack(from, members), ...); }, T::members(value));
  } else {
    std::size_t size = 0;
    unpack(from, size);
    if (size > from.size()) throw std::logic_error("unpack: expected more bytes of a row");
    value.resize(size);
    for (auto& element : value) unpack(from, element);
  }
}

}  // namespace swiftgs::cli
