// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The header of a PLY, rows of its elements, and elements that tell of a photograph.

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <swiftgs/io/scene_file.hpp>

#include "bytes.hpp"
#include "tasks.hpp"

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

/// Where rows of an element of scalars start, evenly chosen from all.
using RowSample = std::vector<std::uint64_t>;

/// Where the rows of each element start, by its name; `vertices` gets some rows of 'vertex'. Throws
/// `FormatError` unless the rows of all elements make up the rest of the file, blanks at the end of an ascii
/// file aside. Asked before memory is taken for them.
std::map<std::string, std::uint64_t> locate_rows(const Source& source, const PlyHeader& header,
                                                 const ProgressMeter& progress, RowSample& vertices);

/// Parses one row of an ascii file, scalars only, into `row`. Returns the offset after it.
std::uint64_t parse_text_row(const Source& source, const PlyElement& element, std::uint64_t position,
                             std::vector<double>& row);

/// Reads what Apple's SHARP stores beside the Gaussians that it makes of a photograph, in elements whose only
/// property has the element's name: the camera, and whether colours are linear. Colours become sRGB, as later
/// versions of SHARP write them. Rows of elements are at `starts`. Adds the elements to `read`; without a
/// camera that is `color_space` alone.
void read_photograph(const Source& source, const PlyHeader& header,
                     const std::map<std::string, std::uint64_t>& starts, SceneFile& file,
                     std::vector<std::string_view>& read);

}  // namespace swiftgs::io
