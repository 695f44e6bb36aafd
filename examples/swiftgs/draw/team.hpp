// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
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

/// The processes that share the views or cases of a command: those that a launcher of MPI started, or this
/// one alone. The first prints and writes results; the others' standard output goes nowhere.
///
/// Functions of results are collective: all processes call them, in one order.
class Team {
 public:
  /// Runs `work` in the team that a launcher started, if there is one, and returns what it returns. Of a
  /// team of several, an error in one process ends all, and one line says which. Built without MPI, throws
  /// `Unavailable` if a launcher started several.
  static int run(int argc, char** argv, const std::function<int()>& work);
  static Team& here();

  int rank() const;
  int size() const;
  bool leads() const { return rank() == 0; }
  bool is_shared() const { return size() > 1; }

  /// Whether case number `i` is for this process.
  bool takes(std::size_t i) const { return i % std::size_t(size()) == std::size_t(rank()); }

  /// Throws unless all processes bring the same text for `what`.
  void require_same(const std::string& what, const std::string& mine) const;
  /// Throws unless all processes find the same content in a file.
  void require_same_file(const std::string& path) const;

  /// The rows of all processes by their numbers, on the first; as they came elsewhere.
  template <class Row>
  void join(std::vector<std::pair<std::uint64_t, Row>>& rows) const {
    if (!is_shared()) return;
    std::string mine;
    pack(mine, std::size_t(rows.size()));
    for (const auto& [number, row] : rows) pack(mine, number), pack(mine, row);
    const std::vector<std::string> each = gather(mine);
    if (!leads()) return;
    rows.clear();
    for (std::string_view text : each) {
      std::size_t count = 0;
      for (unpack(text, count); count > 0; --count) {
        auto& [number, row] = rows.emplace_back();
        unpack(text, number), unpack(text, row);
      }
    }
    std::stable_sort(rows.begin(), rows.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
  }
  /// The least of what all processes say, in all of them.
  std::size_t least(std::size_t mine) const {
    if (!is_shared()) return mine;
    std::string packed;
    pack(packed, mine);
    for (std::string_view text : gather(packed)) {
      std::size_t other = 0;
      unpack(text, other);
      mine = std::min(mine, other);
    }
    return mine;
  }
  /// The sums of what all processes have, element by element, in all of them.
  void add_up(std::vector<std::uint64_t>& sums) const;

  /// Returns when all processes have called it; calls `meanwhile` now and then.
  void meet(const std::function<void()>& meanwhile) const;

  /// Tells the first process that a step is done. Not collective.
  void tell_step() const;
  /// Steps that others have told since this was last asked. Not collective.
  std::size_t steps_told() const;

 private:
  std::vector<std::string> gather(const std::string& mine) const;
};

/// A row with the number that says where it stands among those of all processes.
template <class Row>
using Numbered = std::vector<std::pair<std::uint64_t, Row>>;

/// Rows without their numbers.
template <class Row>
std::vector<Row> rows_of(Numbered<Row>&& numbered) {
  std::vector<Row> rows;
  for (auto& [number, row] : numbered) rows.push_back(std::move(row));
  return rows;
}

}  // namespace swiftgs::cli
