// SPDX-License-Identifier: Apache-2.0
#include "json_entry.hpp"

#include <cmath>

#include <glm/matrix.hpp>

#include "text.hpp"

namespace swiftgs::io {

using nlohmann::json;

namespace {

constexpr int most_levels = 256;

/// Calls visit(i) for each character from `start` on that lies in no string, until it returns false.
template <class Visit>
void visit_outside_strings(std::string_view text, std::size_t start, const Visit& visit) {
  bool in_string = false;
  for (std::size_t i = start; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      in_string = c != '"';
      continue;
    }
    in_string = c == '"';
    if (!visit(i)) return;
  }
}

/// Where an array or object begins that lies in `most_levels` others; npos if none does.
std::size_t find_too_deep(std::string_view text) {
  int depth = 0;
  std::size_t found = text.npos;
  visit_outside_strings(text, 0, [&](std::size_t i) {
    const char c = text[i];
    if (c == ']' || c == '}') --depth;
    if ((c == '[' || c == '{') && ++depth > most_levels) found = i;
    return found == text.npos;
  });
  return found;
}

}  // namespace

json parse_json(const Source& source) {
  expect_utf8(source);
  if (const std::size_t at = find_too_deep(source.text()); at != std::string_view::npos)
    source.fail(at, "at most " + std::to_string(most_levels) + " arrays and objects in each other");
  try {
    return json::parse(source.text());  // which skips a byte order mark
  } catch (const json::parse_error& error) {
    // The parser counts from 1, and counts the end as a byte.
    const std::size_t at = error.byte - (error.byte > 0);
    const bool comment = at < source.bytes.size() && source.text()[at] == '/';
    source.fail(at, comment ? "valid JSON, which has no comments" : "valid JSON");
  } catch (const json::exception&) {
    source.fail(0, "JSON with numbers that a double can hold");
  }
}

std::string listed_keys(const json& object) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : object.items()) keys.push_back(key);
  return keys.empty() ? "no keys" : "the keys " + listed(keys);
}

std::vector<std::uint64_t> offsets_in(std::string_view text, std::uint64_t start) {
  std::vector<std::uint64_t> offsets;
  int depth = 0;
  visit_outside_strings(text, start, [&](std::size_t i) {
    const char c = text[i];
    const bool opens = c == '[' || c == '{';
    if (opens) ++depth;
    if (depth == 1 && (opens || c == ',')) offsets.push_back(text.find_first_not_of(" \t\r\n", i + 1));
    return !((c == ']' || c == '}') && --depth == 0);
  });
  return offsets;
}

std::uint64_t offset_of_member(std::string_view text, std::uint64_t start, std::string_view key) {
  std::uint64_t value = start;
  for (const std::uint64_t member : offsets_in(text, start)) {
    std::size_t end = member + 1;
    while (text[end] != '"') end += text[end] == '\\' ? 2 : 1;
    // A key may be written with escapes, and of members with the same key the last counts.
    if (json::parse(text.substr(member, end + 1 - member)).get_ref<const std::string&>() == key)
      value = text.find_first_not_of(" \t\r\n", text.find(':', end) + 1);
  }
  return value;
}

const json& JsonEntry::member(const char* key) const {
  const auto found = value_.find(key);
  if (found == value_.end()) fail(std::string(what_) + " with '" + key + "'");
  return *found;
}

std::string JsonEntry::string(const char* key) const {
  const json& value = member(key);
  if (!value.is_string()) fail(std::string("'") + key + "' to be a string");
  return value.get<std::string>();
}

dmat3 JsonEntry::matrix(const char* key) const {
  const json& rows = member(key);
  if (!rows.is_array() || rows.size() != 3) fail(std::string("'") + key + "' to be three rows");
  return glm::transpose(dmat3(to_vector(rows[0], key), to_vector(rows[1], key), to_vector(rows[2], key)));
}

Affine JsonEntry::affine(const char* key) const {
  const json& rows = member(key);
  if (!rows.is_array() || rows.size() < 3 || rows.size() > 4)
    fail(std::string("'") + key + "' to be three or four rows");
  Affine affine;
  for (int row = 0; row < int(rows.size()); ++row) {
    const json& values = rows[row];
    if (!values.is_array() || values.size() != 4) fail(std::string("rows of four numbers in '") + key + "'");
    for (int column = 0; column < 4; ++column) place(affine, row, column, values[column], key);
  }
  return affine;
}

Affine JsonEntry::flat_affine(const char* key) const {
  const json& values = member(key);
  if (!values.is_array() || values.size() != 16) fail(std::string("sixteen numbers in '") + key + "'");
  Affine affine;
  for (int i = 0; i < 16; ++i) place(affine, i / 4, i % 4, values[i], key);
  return affine;
}

void JsonEntry::place(Affine& affine, int row, int column, const json& value, const char* key) const {
  const double number = to_number(value, key);
  if (row == 3 && std::abs(number - (column == 3)) > 1e-6)
    fail(std::string("a last row of 0, 0, 0, 1 in '") + key + "'");
  if (row < 3) (column < 3 ? affine.linear[column] : affine.translation)[row] = number;
}

double JsonEntry::to_number(const json& value, const char* key) const {
  if (!value.is_number()) fail(std::string("a number in '") + key + "'");
  return value.get<double>();
}

dvec3 JsonEntry::to_vector(const json& value, const char* key) const {
  if (!value.is_array() || value.size() != 3) fail(std::string("three numbers in '") + key + "'");
  return {to_number(value[0], key), to_number(value[1], key), to_number(value[2], key)};
}

std::uint64_t whole_number(const JsonEntry& entry, const char* key, std::optional<std::uint64_t> otherwise) {
  if (otherwise && !entry.has(key)) return *otherwise;
  const json& value = entry.member(key);
  // Some languages write all numbers with a fraction.
  constexpr double limit = 9007199254740992.0;
  if (value.is_number_float() && value.get<double>() >= 0 && value.get<double>() <= limit &&
      value.get<double>() == double(std::uint64_t(value.get<double>())))
    return std::uint64_t(value.get<double>());
  if (!value.is_number_unsigned())
    entry.fail(std::string("'") + key + "' to be a whole number of at least 0");
  return value.get<std::uint64_t>();
}

}  // namespace swiftgs::io
