// SPDX-License-Identifier: Apache-2.0
#include "ksplat_layout.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include <swiftgs/scene.hpp>

namespace swiftgs::io {
namespace {

constexpr std::uint64_t header_bytes = 4096, section_header_bytes = 1024, centre_bytes = 12;
constexpr double default_middle = 32767;  ///< of 16 bits, where the file says 0
constexpr double default_sh_range = 1.5;

/// Numbers of a header, by their places in it.
struct Header {
  const Source& source;
  std::uint64_t offset;

  template <class T>
  T at(std::uint64_t place) const {
    return load<T>(source.bytes.data() + offset + place);
  }
  std::uint64_t count(std::uint64_t place) const { return at<std::uint32_t>(place); }
  [[noreturn]] void fail(std::uint64_t place, const std::string& expected) const {
    source.fail(offset + place, expected);
  }
};

double range_end(const Header& header, std::uint64_t place, double otherwise) {
  const double value = header.at<float>(place);
  if (!std::isfinite(value)) header.fail(place, "a finite range of SH coefficients");
  return value == 0 ? otherwise : value;
}

/// What bytes of coefficients stand for, which only level 2 has.
void set_sh_range(const Header& header, KsplatLayout& layout) {
  const double least = range_end(header, 36, -default_sh_range),
               most = range_end(header, 40, default_sh_range);
  for (int byte = 0; byte < 256; ++byte)
    layout.sh_of_byte[std::size_t(byte)] = float(least + byte / 255.0 * (most - least));
}

/// Reads where the buckets of a section are, from `reader` at its start. At level 0 there are none, or they
/// are of no use.
void parse_buckets(const Header& header, ByteReader& reader, int level, KsplatSection& section) {
  const std::uint64_t room = header.count(4);
  const std::uint64_t buckets = header.count(12), partial = header.count(36);
  section.bucket_size = header.count(8), section.full_buckets = header.count(32);
  const std::uint64_t bytes_of_centre = header.at<std::uint16_t>(20);
  std::uint64_t end = section.bucket_size * section.full_buckets;
  if (level > 0) {
    if (buckets > 0 && bytes_of_centre != centre_bytes)
      header.fail(20, "12 bytes for the centre of a bucket");
    if (section.full_buckets + partial > buckets)
      header.fail(32, "at most " + std::to_string(buckets) + " buckets, found " +
                          std::to_string(section.full_buckets) + " full and " + std::to_string(partial) +
                          " others");
    if (end > room)
      header.fail(
          32, "full buckets of at most " + std::to_string(room) + " Gaussians, found " + std::to_string(end));
  }
  reader.expect(partial, 4, "counts of buckets");
  section.partial_ends.reserve(partial);
  for (std::uint64_t i = 0; i < partial; ++i)
    section.partial_ends.push_back(end += reader.read<std::uint32_t>("the count of a bucket"));
  if (level > 0 && end < section.count)
    header.fail(32,
                "buckets for " + std::to_string(section.count) + " Gaussians, found " + std::to_string(end));
  section.centres = reader.take(buckets * bytes_of_centre, "centres of buckets");
  const double block = header.at<float>(16);
  const std::uint64_t range = header.count(24);
  section.middle = range == 0 ? default_middle : double(range);
  section.unit = block / 2 / section.middle;
}

KsplatSection parse_section(const Header& header, ByteReader& reader, int level) {
  KsplatSection section;
  section.count = header.count(0);
  const std::uint64_t room = header.count(4);
  if (section.count > room)
    header.fail(0, "at most " + std::to_string(room) + " Gaussians in the section, found " +
                       std::to_string(section.count));
  section.sh_degree = header.at<std::uint16_t>(40);
  if (section.sh_degree > max_sh_degree)
    header.fail(40, "SH degree 0 to 3, found " + std::to_string(section.sh_degree));
  const auto harmonics = 3 * std::size_t(sh_rest_count(section.sh_degree));
  section.record_bytes = ksplat_base_bytes[level] + ksplat_sh_bytes[level] * harmonics;
  parse_buckets(header, reader, level, section);
  reader.expect(room, section.record_bytes, "Gaussians");
  section.records = reader.take(room * section.record_bytes, "Gaussians");
  return section;
}

}  // namespace

bool looks_like_ksplat(std::string_view text, std::string_view /*name*/) {
  if (text.size() < header_bytes + section_header_bytes) return false;
  const auto* bytes = reinterpret_cast<const std::byte*>(text.data());
  const auto number = [&](std::size_t at) { return std::uint64_t(load<std::uint32_t>(bytes + at)); };
  const std::uint64_t most_sections = (text.size() - header_bytes) / section_header_bytes;
  return text[0] == 0 && text[1] != 0 && text[2] == 0 && text[3] == 0 && number(4) >= 1 &&
         number(4) <= most_sections && number(8) <= number(4) && load<std::uint16_t>(bytes + 20) <= 2;
}

KsplatLayout parse_ksplat(const Source& source) {
  ByteReader reader(source);
  reader.expect(1, header_bytes, "headers of a .ksplat scene");
  reader.take(header_bytes, "a header");
  const Header header{source, 0};
  const int major = header.at<std::uint8_t>(0), minor = header.at<std::uint8_t>(1);
  if (major != 0 || minor < 1)
    header.fail(
        0, "version 0.1 or later of .ksplat, found " + std::to_string(major) + "." + std::to_string(minor));
  KsplatLayout layout;
  layout.level = header.at<std::uint16_t>(20);
  if (layout.level > 2) header.fail(20, "compression level 0 to 2, found " + std::to_string(layout.level));
  if (layout.level == 2) set_sh_range(header, layout);

  const std::uint64_t sections = header.count(4);
  reader.expect(sections, section_header_bytes, "headers of sections");
  reader.take(sections * section_header_bytes, "headers of sections");
  for (std::uint64_t i = 0; i < sections; ++i) {
    const Header section_header{source, header_bytes + i * section_header_bytes};
    KsplatSection section = parse_section(section_header, reader, layout.level);
    section.first = layout.count;
    layout.count += section.count;
    layout.sh_degree = std::max(layout.sh_degree, section.count > 0 ? section.sh_degree : 0);
    layout.sections.push_back(std::move(section));
  }
  reader.expect_end("the last section");
  if (layout.count == 0 || layout.count != header.count(16))
    header.fail(16, "as many Gaussians as the sections have, at least 1, found " +
                        std::to_string(header.count(16)) + " and " + std::to_string(layout.count));
  return layout;
}

}  // namespace swiftgs::io
