// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <sstream>
#include <string>
#include <vector>

#include <swiftgs/io/scene_file.hpp>

#include "files.hpp"

namespace swiftgs::test {

/// A property of one vertex: type and name as the header says them, and its value.
struct PlyValue {
  std::string type, name;
  double value;
};

inline constexpr const char* ply_formats[] = {"binary_little_endian", "binary_big_endian", "ascii"};

/// The properties of a Gaussian without SH, all floats.
inline std::vector<PlyValue> plain_gaussian() {
  return {{"float", "x", 1},         {"float", "y", 2},         {"float", "z", -3},
          {"float", "f_dc_0", 0.25}, {"float", "f_dc_1", -0.5}, {"float", "f_dc_2", 0.75},
          {"float", "opacity", 0},   {"float", "scale_0", -1},  {"float", "scale_1", -2},
          {"float", "scale_2", -3},  {"float", "rot_0", 2},     {"float", "rot_1", 0},
          {"float", "rot_2", 0},     {"float", "rot_3", 0}};
}

/// Checks that `file` holds the one Gaussian of `plain_gaussian`, whatever its layout.
inline void check_plain(const SceneFile& file) {
  const Scene& scene = file.scene;
  REQUIRE(scene.size() == 1);
  CHECK_NOTHROW(validate(scene));
  CHECK(scene.means[0] == vec3(1, 2, -3));
  CHECK(scene.sh0[0] == vec3(0.25f, -0.5f, 0.75f));
  CHECK(scene.opacities[0] == 0.5f);
  CHECK(scene.scales[0] == vec3(std::exp(-1.0f), std::exp(-2.0f), std::exp(-3.0f)));
  CHECK(scene.rotations[0] == Quaternion{1, 0, 0, 0});
  CHECK(file.stored == 1);
  CHECK(file.left_out.total() == 0);
}

inline PlyValue& property(std::vector<PlyValue>& values, const std::string& name) {
  return *std::find_if(values.begin(), values.end(), [&](const PlyValue& v) { return v.name == name; });
}

inline void remove(std::vector<PlyValue>& values, const std::string& name) {
  std::erase_if(values, [&](const PlyValue& v) { return v.name == name; });
}

/// One value as `type` in a little-endian (or, with `big`, a big-endian) file.
inline void append_value(std::string& to, const std::string& type, double value, bool big = false) {
  std::string raw;
  if (type == "double" || type == "float64")
    append(raw, value);
  else if (type == "float" || type == "float32")
    append(raw, float(value));
  else
    append(raw, std::int64_t(value));
  // The lower bytes of an integer come first.
  if (contains(type, "char") || contains(type, "int8")) raw.resize(1);
  if (contains(type, "short") || contains(type, "int16")) raw.resize(2);
  if (type == "int" || type == "uint" || contains(type, "int32")) raw.resize(4);
  if (big) std::reverse(raw.begin(), raw.end());
  to += raw;
}

struct PlyParts {
  std::string format = "binary_little_endian";
  std::string before{}, before_rows{};  ///< header lines and rows of elements before the vertices
  std::string after{}, after_rows{};
  std::string line_break = "\n";
  int repeat = 1;  ///< how often the vertex is stored
};

/// A PLY file with `vertex` in it. Header lines in `parts` end in "\n".
inline std::string ply(const std::vector<PlyValue>& vertex, const PlyParts& parts = {}) {
  std::string header = "ply\nformat " + parts.format + " 1.0\n" + parts.before + "element vertex " +
                       std::to_string(parts.repeat) + "\n";
  std::string row;
  for (const PlyValue& v : vertex) {
    header += "property " + v.type + " " + v.name + "\n";
    if (parts.format == "ascii") {
      std::ostringstream number;
      number.precision(9);
      number << v.value << ' ';
      row += number.str();
    } else {
      append_value(row, v.type, v.value, parts.format == "binary_big_endian");
    }
  }
  if (parts.format == "ascii") row += '\n';
  header += parts.after + "end_header\n";
  std::string file;
  for (const char c : header) c == '\n' ? file += parts.line_break : file += c;
  file += parts.before_rows;
  for (int i = 0; i < parts.repeat; ++i) file += row;
  return file + parts.after_rows;
}

}  // namespace swiftgs::test
