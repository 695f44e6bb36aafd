// SPDX-License-Identifier: Apache-2.0
#include "spz_content.hpp"

#include <limits>
#include <numeric>
#include <string>

#include <swiftgs/scene.hpp>

namespace swiftgs::io {

SpzHeader parse_spz_header(const Source& source, const std::byte* first) {
  const auto byte = [&](int i) { return std::to_integer<int>(first[i]); };
  if (load<std::uint32_t>(first) != spz_magic) source.fail(0, "an SPZ scene ('NGSP' at its start)");
  SpzHeader header{.version = load<std::uint32_t>(first + 4),
                   .count = load<std::uint32_t>(first + 8),
                   .sh_degree = byte(12),
                   .fractional_bits = byte(13),
                   .antialiased = (byte(14) & 1) != 0,
                   .has_extensions = (byte(14) & 2) != 0};
  const auto expect = [&](bool holds, int offset, const std::string& what, std::uint32_t found) {
    if (!holds) source.fail(offset, what + ", found " + std::to_string(found));
  };
  expect(header.version >= 1 && header.version <= 4, 4, "SPZ version 1 to 4", header.version);
  expect(header.count >= 1 && header.count <= std::uint32_t(std::numeric_limits<std::int32_t>::max()), 8,
         "1 to 2147483647 Gaussians", header.count);
  const int max_degree = header.version < 3 ? 3 : 4;
  expect(header.sh_degree <= max_degree, 12, "SH degree 0 to " + std::to_string(max_degree), byte(12));
  expect(header.fractional_bits <= 30, 13, "0 to 30 fractional bits", byte(13));
  return header;
}

std::array<std::size_t, spz_attributes> spz_sizes(const SpzHeader& header) {
  const std::size_t positions = header.version == 1 ? 6 : 9, rotations = header.version < 3 ? 3 : 4;
  return {positions, 1, 3, 3, rotations, 3 * std::size_t(sh_rest_count(header.sh_degree))};
}

std::size_t spz_total(const SpzHeader& header) {
  const auto sizes = spz_sizes(header);
  return header.count * std::accumulate(sizes.begin(), sizes.end(), std::size_t(0));
}

void split_arrays(SpzContent& content, const std::byte* data) {
  const auto sizes = spz_sizes(content.header);
  for (int a = 0; a < spz_attributes; ++a) {
    content.arrays[a] = {data, content.header.count * sizes[a]};
    data += content.arrays[a].size();
  }
}

SpzCoordinates parse_spz_extensions(const Source& source, std::span<const std::byte> records,
                                    std::optional<std::uint64_t> offset) {
  constexpr std::uint32_t coordinate_system = 0xADBE0003;
  const std::byte* const start = records.data();
  const auto here = [&] { return offset ? *offset + std::uint64_t(records.data() - start) : 0; };
  SpzCoordinates found;
  while (!records.empty()) {
    if (records.size() < 8) source.fail(here(), "an SPZ extension of at least 8 bytes");
    const auto type = load<std::uint32_t>(records.data()), length = load<std::uint32_t>(records.data() + 4);
    records = records.subspan(8);
    if (length > records.size())
      source.fail(here(), "an SPZ extension of at most " + std::to_string(records.size()) + " bytes, found " +
                              std::to_string(length));
    if (type == coordinate_system) {
      if (length != 4) source.fail(here(), "a coordinate system of 4 bytes");
      found = {load<std::uint32_t>(records.data()), here()};
    }
    records = records.subspan(length);
  }
  return found;
}

}  // namespace swiftgs::io
