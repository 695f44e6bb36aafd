// SPDX-License-Identifier: Apache-2.0
#include <swiftgs/edit/origin.hpp>

#include "ply_header.hpp"
#include "text.hpp"

namespace swiftgs::io {
namespace {

[[noreturn]] void fail_length(const Source& source, std::uint64_t position) {
  source.fail(position, "a list length of 0 or more");
}

std::uint64_t read_length(ByteReader& reader, const Source& source, PlyType type, std::endian order) {
  const std::uint64_t position = reader.position();
  const std::byte* at = reader.take(size_of(type), "a list length");
  std::int64_t length = 0;
  switch (type) {
    case PlyType::i8:
      length = load<std::int8_t>(at, order);
      break;
    case PlyType::u8:
      length = load<std::uint8_t>(at, order);
      break;
    case PlyType::i16:
      length = load<std::int16_t>(at, order);
      break;
    case PlyType::u16:
      length = load<std::uint16_t>(at, order);
      break;
    case PlyType::i32:
      length = load<std::int32_t>(at, order);
      break;
    default:
      length = load<std::uint32_t>(at, order);
      break;
  }
  if (length < 0) fail_length(source, position);
  return std::uint64_t(length);
}

/// Tells how far a walk through the file is, every few megabytes.
class Walk {
 public:
  Walk(const Source& source, const ProgressMeter& progress) : source_(source), progress_(progress) {
    progress.report(0);
  }

  const Source& source() const { return source_; }
  void reach(std::uint64_t position) {
    if (position < next_) return;
    next_ = position + (1 << 22);
    progress_.report(double(position) / double(source_.bytes.size()));
  }

 private:
  const Source& source_;
  const ProgressMeter& progress_;
  std::uint64_t next_ = 1 << 22;
};

std::uint64_t skip_binary_row(const Source& source, const PlyElement& element, std::endian order,
                              std::uint64_t position) {
  ByteReader reader(source, position);
  for (const PlyProperty& property : element.properties) {
    const std::uint64_t values =
        property.list_count ? read_length(reader, source, *property.list_count, order) : 1;
    reader.take(values * size_of(property.type), property.name.c_str());  // at most 2^32 * 8
  }
  return reader.position();
}

std::uint64_t skip_text_row(Walk& walk, const PlyElement& element, std::uint64_t position) {
  const Source& source = walk.source();
  Tokens tokens(source.text(), position);
  for (const PlyProperty& property : element.properties) {
    std::uint64_t values = 1;
    if (property.list_count && !to_number(tokens.next(), values)) fail_length(source, tokens.position());
    for (; values > 0; --values) {
      if (tokens.next().empty()) source.fail(tokens.position(), "a value of '" + property.name + "'");
      walk.reach(tokens.position());
    }
  }
  return tokens.position();
}

/// The offset after all rows of `element`, which start at `position`. Adds some to `sample`, unless it is
/// null.
std::uint64_t skip_rows(Walk& walk, const PlyElement& element, PlyEncoding encoding, std::uint64_t position,
                        RowSample* sample) {
  const Source& source = walk.source();
  const std::uint64_t row_bytes = element.row_bytes(encoding);
  if (row_bytes == 0) return position;
  const std::uint64_t remaining = source.bytes.size() - position;
  // The last number of an ascii file needs no separator.
  const std::uint64_t room = remaining + (encoding == PlyEncoding::ascii);
  if (element.count > room / row_bytes)
    source.fail(position, std::to_string(element.count) + " rows of '" + element.name + "' of at least " +
                              std::to_string(row_bytes) + " bytes, found " + std::to_string(remaining) +
                              " bytes");
  if (encoding != PlyEncoding::ascii && !element.has_lists()) {
    if (sample)
      OriginChoice::for_each_sample(element.count,
                                    [&](std::size_t i) { sample->push_back(position + i * row_bytes); });
    return position + element.count * row_bytes;
  }

  const std::endian order = encoding == PlyEncoding::big_endian ? std::endian::big : std::endian::little;
  std::vector<std::uint64_t> chosen;
  if (sample) OriginChoice::for_each_sample(element.count, [&](std::size_t i) { chosen.push_back(i); });
  auto next = chosen.begin();
  for (std::uint64_t row = 0; row < element.count; ++row) {
    if (next != chosen.end() && *next == row) sample->push_back(position), ++next;
    position = encoding == PlyEncoding::ascii ? skip_text_row(walk, element, position)
                                              : skip_binary_row(source, element, order, position);
    walk.reach(position);
  }
  return position;
}

/// Throws unless the file ends at `position`.
void expect_end(const Source& source, PlyEncoding encoding, std::uint64_t position) {
  if (encoding == PlyEncoding::ascii && Tokens(source.text(), position).at_end()) return;
  if (position != source.bytes.size())
    source.fail(position, "the end of the file after the last element, found " +
                              std::to_string(source.bytes.size() - position) + " more bytes");
}

}  // namespace

std::map<std::string, std::uint64_t> locate_rows(const Source& source, const PlyHeader& header,
                                                 const ProgressMeter& progress, RowSample& vertices) {
  Walk walk(source, progress);
  std::map<std::string, std::uint64_t> starts;
  std::uint64_t position = header.size;
  for (const PlyElement& element : header.elements) {
    starts[element.name] = position;
    position =
        skip_rows(walk, element, header.encoding, position, element.name == "vertex" ? &vertices : nullptr);
  }
  expect_end(source, header.encoding, position);
  return starts;
}

std::uint64_t parse_text_row(const Source& source, const PlyElement& element, std::uint64_t position,
                             std::vector<double>& row) {
  Tokens tokens(source.text(), position);
  row.resize(element.properties.size());
  for (std::size_t i = 0; i < row.size(); ++i) {
    const std::string_view word = tokens.next();
    if (!to_number(word, row[i]))
      source.fail(tokens.position() - word.size(), "a number for '" + element.properties[i].name + "'");
  }
  return tokens.position();
}

}  // namespace swiftgs::io
