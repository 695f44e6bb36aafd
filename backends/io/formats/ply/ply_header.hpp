// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bytes.hpp"

namespace swiftgs::io {

enum class PlyType : std::uint8_t { i8, u8, i16, u16, i32, u32, f32, f64 };
enum class PlyEncoding { ascii, little_endian, big_endian };

std::size_t size_of(PlyType type);
inline bool is_integer(PlyType type) { return type != PlyType::f32 && type != PlyType::f64; }

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::f32;
  std::optional<PlyType> list_count;  ///< type of a list's length; a scalar has none
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
  std::uint64_t declared_at = 0;  ///< byte of its line in the header

  bool has_lists() const;
  /// Bytes that one row takes at least: exactly, if there are no lists.
  std::uint64_t row_bytes(PlyEncoding encoding) const;
};

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::ascii;
  std::vector<PlyElement> elements;
  std::vector<std::string> comments;  ///< of `comment` and `obj_info` lines, without the keyword
  std::uint64_t size = 0;             ///< offset of the first row

  const char* encoding_name() const;
  const PlyElement* find(std::string_view element) const;  ///< null if there is none of that name
};

/// Parses up to and with `end_header`. Accepts a byte order mark, CRLF, blanks at the ends of lines, comments
/// anywhere, and both families of type names.
PlyHeader parse_ply_header(const Source& source);

}  // namespace swiftgs::io
