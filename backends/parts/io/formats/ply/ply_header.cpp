// SPDX-License-Identifier: Apache-2.0
#include "ply_header.hpp"

#include <algorithm>
#include <string_view>
#include <unordered_set>
#include <utility>

#include "text.hpp"

namespace swiftgs::io {
namespace {

constexpr std::pair<std::string_view, PlyType> type_names[] = {
    {"char", PlyType::i8},   {"int8", PlyType::i8},     {"uchar", PlyType::u8},   {"uint8", PlyType::u8},
    {"short", PlyType::i16}, {"int16", PlyType::i16},   {"ushort", PlyType::u16}, {"uint16", PlyType::u16},
    {"int", PlyType::i32},   {"int32", PlyType::i32},   {"uint", PlyType::u32},   {"uint32", PlyType::u32},
    {"float", PlyType::f32}, {"float32", PlyType::f32}, {"double", PlyType::f64}, {"float64", PlyType::f64}};

/// One header line after another, with the place of each for errors.
class HeaderParser {
 public:
  explicit HeaderParser(const Source& source) : source_(source), position_(mark_bytes(source.text())) {}

  PlyHeader parse() {
    const std::string_view start = next_line();
    Tokens first(start);
    if (first.next() != "ply" || !first.at_end())
      fail(start.find('\r') == start.npos
               ? "'ply' on the first line"
               : "header lines that end in LF or CR LF, found CR alone, as old Macs wrote");
    while (true) {
      const std::string_view line = next_line();
      Tokens tokens(line);
      const std::string_view keyword = tokens.next();
      if (keyword == "comment" || keyword == "obj_info")
        header_.comments.emplace_back(tokens.rest());
      else if (keyword == "format")
        parse_format(tokens);
      else if (keyword == "element")
        parse_element(tokens);
      else if (keyword == "property")
        parse_property(tokens);
      else if (keyword == "end_header")
        break;
      else if (!keyword.empty())
        fail("a PLY header line (format, comment, element, property or end_header)");
    }
    if (!has_format_) fail("a 'format' line before 'end_header'");
    header_.size = position_;
    return std::move(header_);
  }

 private:
  [[noreturn]] void fail(const std::string& expected) const { source_.fail(line_start_, expected); }

  std::string_view next_line() {
    const std::string_view text = source_.text();
    line_start_ = position_;
    if (position_ == text.size()) fail("a PLY header that ends in a line 'end_header'");
    std::string_view line = text.substr(line_start_, text.find('\n', line_start_) - line_start_);
    position_ = std::min(line_start_ + line.size() + 1, text.size());
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
  }

  void parse_format(Tokens& tokens) {
    const std::string_view encoding = tokens.next();
    if (has_format_ || !header_.elements.empty()) fail("one 'format' line, before the elements");
    if (encoding == "ascii")
      header_.encoding = PlyEncoding::ascii;
    else if (encoding == "binary_little_endian")
      header_.encoding = PlyEncoding::little_endian;
    else if (encoding == "binary_big_endian")
      header_.encoding = PlyEncoding::big_endian;
    else
      fail("format ascii, binary_little_endian or binary_big_endian");
    if (tokens.next() != "1.0" || !tokens.at_end()) fail("PLY version 1.0");
    has_format_ = true;
  }

  void parse_element(Tokens& tokens) {
    PlyElement element;
    element.name = tokens.next();
    element.declared_at = line_start_;
    if (!has_format_) fail("a 'format' line before the first element");
    if (element.name.empty() || !to_number(tokens.next(), element.count) || !tokens.at_end())
      fail("'element NAME COUNT' with a count of 0 to 2^64 - 1");
    if (!element_names_.insert(element.name).second) fail("each element name once");
    property_names_.clear();
    header_.elements.push_back(std::move(element));
  }

  void parse_property(Tokens& tokens) {
    if (header_.elements.empty()) fail("an element before the first property");
    PlyProperty property;
    std::string_view type = tokens.next();
    if (type == "list") {
      property.list_count = type_named(tokens.next());
      if (!is_integer(*property.list_count)) fail("a list length of an integer type");
      type = tokens.next();
    }
    property.type = type_named(type);
    property.name = tokens.next();
    if (property.name.empty() || !tokens.at_end()) fail("'property TYPE NAME'");
    if (!property_names_.insert(property.name).second) fail("each property name once in an element");
    header_.elements.back().properties.push_back(std::move(property));
  }

  PlyType type_named(std::string_view name) const {
    for (const auto& [known, type] : type_names)
      if (name == known) return type;
    fail("a PLY type (char, uchar, short, ushort, int, uint, float, double, or int8 to float64)");
  }

  const Source& source_;
  PlyHeader header_;
  std::unordered_set<std::string> element_names_, property_names_;
  std::uint64_t position_ = 0, line_start_ = 0;
  bool has_format_ = false;
};

}  // namespace

std::size_t size_of(PlyType type) {
  switch (type) {
    case PlyType::i8:
    case PlyType::u8:
      return 1;
    case PlyType::i16:
    case PlyType::u16:
      return 2;
    case PlyType::f64:
      return 8;
    default:
      return 4;
  }
}

bool PlyElement::has_lists() const {
  for (const PlyProperty& property : properties)
    if (property.list_count) return true;
  return false;
}

std::uint64_t PlyElement::row_bytes(PlyEncoding encoding) const {
  std::uint64_t bytes = 0;
  for (const PlyProperty& property : properties)
    // A character and a separator are the least that a number takes as text.
    bytes += encoding == PlyEncoding::ascii ? 2 : size_of(property.list_count.value_or(property.type));
  return bytes;
}

const char* PlyHeader::encoding_name() const {
  switch (encoding) {
    case PlyEncoding::ascii:
      return "ascii";
    case PlyEncoding::little_endian:
      return "binary_little_endian";
    default:
      return "binary_big_endian";
  }
}

const PlyElement* PlyHeader::find(std::string_view element) const {
  for (const PlyElement& candidate : elements)
    if (candidate.name == element) return &candidate;
  return nullptr;
}

PlyHeader parse_ply_header(const Source& source) { return HeaderParser(source).parse(); }

}  // namespace swiftgs::io
