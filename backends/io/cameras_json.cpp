// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <string>

#include <nlohmann/json.hpp>

#include "camera_parsing.hpp"

namespace swiftgs::io {
namespace {

using nlohmann::json;

/// Where the elements start of the array that `text`, which is valid JSON, consists of.
std::vector<std::uint64_t> offsets_of_elements(std::string_view text) {
  std::vector<std::uint64_t> offsets;
  int depth = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      in_string = c != '"';
      continue;
    }
    in_string = c == '"';
    if (c == '[' || c == '{') ++depth;
    if (c == ']' || c == '}') --depth;
    if (depth == 1 && (c == '[' || c == ',')) offsets.push_back(text.find_first_not_of(" \t\r\n", i + 1));
  }
  return offsets;
}

/// One object of the array.
class Entry {
 public:
  Entry(const Source& source, const json& value, std::uint64_t offset)
      : source_(source), value_(value), offset_(offset) {
    if (!value.is_object()) fail("a camera (a JSON object)");
  }

  std::uint64_t offset() const { return offset_; }

  double number(const char* key) const { return to_number(member(key), key); }

  dvec3 vector(const char* key) const { return to_vector(member(key), key); }

  /// The rows of a matrix.
  std::array<dvec3, 3> rows(const char* key) const {
    const json& rows = member(key);
    if (!rows.is_array() || rows.size() != 3) fail(std::string("'") + key + "' to be three rows");
    return {to_vector(rows[0], key), to_vector(rows[1], key), to_vector(rows[2], key)};
  }

  std::string string(const char* key) const {
    const json& value = member(key);
    if (!value.is_string()) fail(std::string("'") + key + "' to be a string");
    return value.get<std::string>();
  }

 private:
  [[noreturn]] void fail(const std::string& expected) const { source_.fail(offset_, expected); }

  const json& member(const char* key) const {
    const auto found = value_.find(key);
    if (found == value_.end()) fail(std::string("a camera with '") + key + "'");
    return *found;
  }

  double to_number(const json& value, const char* key) const {
    if (!value.is_number()) fail(std::string("a number in '") + key + "'");
    return value.get<double>();
  }

  dvec3 to_vector(const json& value, const char* key) const {
    if (!value.is_array() || value.size() != 3) fail(std::string("three numbers in '") + key + "'");
    return {to_number(value[0], key), to_number(value[1], key), to_number(value[2], key)};
  }

  const Source& source_;
  const json& value_;
  std::uint64_t offset_;
};

Camera camera_of(const Source& source, const Entry& entry) {
  Camera camera;
  camera.name = entry.string("img_name");
  camera.width = to_side(source, entry.offset(), entry.number("width"));
  camera.height = to_side(source, entry.offset(), entry.number("height"));
  camera.fx = entry.number("fx"), camera.fy = entry.number("fy");
  camera.cx = 0.5 * camera.width, camera.cy = 0.5 * camera.height;

  // The file holds the pose of the camera in the world; the inverse of its rotation has the rows as columns.
  const auto rows = entry.rows("rotation");
  const dvec3 centre = entry.vector("position");
  camera.rotation = dmat3(rows[0], rows[1], rows[2]);
  camera.translation = dvec3(0.0);
  for (int column = 0; column < 3; ++column) camera.translation -= camera.rotation[column] * centre[column];
  expect_valid(source, entry.offset(), camera);
  return camera;
}

}  // namespace

std::vector<Camera> parse_cameras_json(const Source& source) {
  json root;
  try {
    root = json::parse(source.text());
  } catch (const json::parse_error& error) {
    // The parser counts from 1, and counts the end as a byte.
    source.fail(error.byte - (error.byte > 0), "valid JSON");
  } catch (const json::exception&) {
    source.fail(0, "JSON with numbers that a double can hold");
  }
  if (!root.is_array()) source.fail(0, "an array of cameras, as INRIA's cameras.json has");
  std::vector<Camera> cameras;
  cameras.reserve(root.size());
  const std::vector<std::uint64_t> offsets = offsets_of_elements(source.text());
  for (std::size_t i = 0; i < root.size(); ++i)
    cameras.push_back(camera_of(source, Entry(source, root[i], offsets[i])));
  return cameras;
}

}  // namespace swiftgs::io
