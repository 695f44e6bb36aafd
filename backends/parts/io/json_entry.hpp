// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include <swiftgs/edit/affine.hpp>
#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/math.hpp>

#include "bytes.hpp"

namespace swiftgs::io {

/// All of `source`. Throws `FormatError` unless it is JSON whose numbers a double can hold, and whose arrays
/// and objects lie 256 deep at most: copies and readers of a value call themselves for each level.
SWIFTGS_API nlohmann::json parse_json(const Source& source);

/// The keys of an object, as messages list them.
std::string listed_keys(const nlohmann::json& object);

/// Where the elements start of the array, or the members of the object, that starts at `start` of valid JSON.
std::vector<std::uint64_t> offsets_in(std::string_view text, std::uint64_t start);

/// Where the value of the member `key` starts in the object at `start` of valid JSON, which has that member.
std::uint64_t offset_of_member(std::string_view text, std::uint64_t start, std::string_view key);

/// An object of a JSON file. Each reader throws `FormatError` at the object's offset, naming the member that
/// is missing or wrong. The source and the value must outlive it.
class JsonEntry {
 public:
  /// `what` is what the object stands for, such as "a camera".
  JsonEntry(const Source& source, const nlohmann::json& value, std::uint64_t offset, const char* what)
      : source_(source), value_(value), offset_(offset), what_(what) {
    if (!value.is_object()) fail(std::string(what) + " (a JSON object)");
  }

  [[noreturn]] void fail(const std::string& expected) const { source_.fail(offset_, expected); }

  const Source& source() const { return source_; }
  std::uint64_t offset() const { return offset_; }
  /// Whether it has `key`. Null means absent.
  bool has(const char* key) const {
    const auto found = value_.find(key);
    return found != value_.end() && !found->is_null();
  }
  const nlohmann::json& members() const { return value_; }
  const nlohmann::json& member(const char* key) const;

  double number(const char* key) const { return to_number(member(key), key); }
  /// The number at `index` of an array.
  double number(const char* key, std::size_t index) const { return to_number(member(key).at(index), key); }
  std::string string(const char* key) const;
  dvec3 vector(const char* key) const { return to_vector(member(key), key); }

  /// A matrix as the file has it, by rows; stored by columns, as GLM does.
  dmat3 matrix(const char* key) const;

  /// Three rows, or four of which the last is 0, 0, 0, 1.
  Affine affine(const char* key) const;

  /// The same in one list of sixteen numbers, by rows.
  Affine flat_affine(const char* key) const;

 private:
  void place(Affine& affine, int row, int column, const nlohmann::json& value, const char* key) const;
  double to_number(const nlohmann::json& value, const char* key) const;
  dvec3 to_vector(const nlohmann::json& value, const char* key) const;

  const Source& source_;
  const nlohmann::json& value_;
  std::uint64_t offset_;
  const char* what_;
};

/// The member `key` of `entry`, a whole number of at least 0, or `otherwise` if it is absent.
std::uint64_t whole_number(const JsonEntry& entry, const char* key,
                           std::optional<std::uint64_t> otherwise = {});

}  // namespace swiftgs::io
