// SPDX-License-Identifier: Apache-2.0

#include "spz_content.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

#include <swiftgs/project/sh.hpp>
#include <swiftgs/scene.hpp>

#include "scene_building.hpp"

namespace swiftgs::io {
namespace {

std::string hexadecimal(std::uint32_t value) {
  std::array<char, 8> digits{};
  char* const end = std::to_chars(digits.data(), digits.data() + digits.size(), value, 16).ptr;
  return "0x" + std::string(digits.data(), std::size_t(end - digits.data()));
}

}  // namespace

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
  expect(header.sh_degree <= 4, 12, "SH degree 0 to 4", byte(12));
  expect(header.version == 1 || header.fractional_bits <= 30, 13, "0 to 30 fractional bits", byte(13));
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

SpzExtensions parse_spz_extensions(const Source& source, std::span<const std::byte> records,
                                   std::optional<std::uint64_t> offset) {
  const std::byte* const start = records.data();
  const auto here = [&] { return offset ? *offset + std::uint64_t(records.data() - start) : 0; };
  SpzExtensions found;
  bool orbit = false;
  std::uint32_t unknown = 0, first_unknown = 0;
  while (!records.empty()) {
    if (records.size() < 8) source.fail(here(), "an SPZ extension of at least 8 bytes");
    const auto type = load<std::uint32_t>(records.data()), length = load<std::uint32_t>(records.data() + 4);
    records = records.subspan(8);
    if (length > records.size())
      source.fail(here(), "an SPZ extension of at most " + std::to_string(records.size()) + " bytes, found " +
                              std::to_string(length));
    if (type == spz_coordinate_system) {
      if (length != 4) source.fail(here(), "a coordinate system of 4 bytes");
      found.system = load<std::uint32_t>(records.data()), found.offset = here();
    } else if (type == spz_safe_orbit_camera) {
      orbit = true;
    } else if (unknown++ == 0) {
      first_unknown = type;
    }
    records = records.subspan(length);
  }
  if (orbit) found.notes.push_back("Limits of an orbit camera (extension 0xADBE0002) were left out.");
  if (unknown != 0)
    found.notes.push_back("Unknown extensions were left out: " + std::to_string(unknown) +
                          ", the first of type " + hexadecimal(first_unknown) + ".");
  return found;
}

namespace {

/// Little-endian two's complement; exact in a float.
float int24_to_float(const std::byte* at) {
  const auto byte = [&](int i) { return std::to_integer<std::int32_t>(at[i]); };
  const std::int32_t value = byte(0) | byte(1) << 8 | byte(2) << 16;
  return float(value >= 1 << 23 ? value - (1 << 24) : value);
}

Quaternion decode_xyz(const std::byte* at) {
  const auto component = [&](int i) { return float(std::to_integer<int>(at[i])) / 127.5f - 1; };
  const float x = component(0), y = component(1), z = component(2);
  return normalised(std::sqrt(std::max(0.0f, 1 - x * x - y * y - z * z)), x, y, z);
}

}  // namespace

SpzTables::SpzTables() {
  for (int byte = 0; byte < 256; ++byte) {
    colour[byte] = (float(byte) / 255 - 0.5f) / 0.15f;
    scale[byte] = std::exp(float(byte) / 16 - 10);
  }
}

vec3 SpzTables::three(const std::array<float, 256>& table, const std::byte* at) {
  return {table[std::to_integer<std::size_t>(at[0])], table[std::to_integer<std::size_t>(at[1])],
          table[std::to_integer<std::size_t>(at[2])]};
}

float decode_spz_opacity(const std::byte* at) { return float(std::to_integer<int>(*at)) / 255; }

vec3 decode_spz_position(const SpzHeader& header, const std::byte* at) {
  if (header.version == 1) {
    const auto half = [&](int i) { return half_to_float(load<std::uint16_t>(at + 2 * i)); };
    return {half(0), half(1), half(2)};
  }
  const float unit = 1 / float(1u << header.fractional_bits);
  return {unit * int24_to_float(at), unit * int24_to_float(at + 3), unit * int24_to_float(at + 6)};
}

Quaternion decode_smallest_three(std::uint32_t packed) {
  const int largest = int(packed >> 30);
  std::array<float, 4> xyzw;
  float squares = 0;
  for (int i = 3; i >= 0; --i) {
    if (i == largest) continue;
    const float magnitude = float(packed & 511) / 511 * float(std::sqrt(0.5));
    xyzw[i] = packed & 512 ? -magnitude : magnitude;
    squares += magnitude * magnitude;
    packed >>= 10;
  }
  xyzw[largest] = std::sqrt(std::max(0.0f, 1 - squares));
  return normalised(xyzw[3], xyzw[0], xyzw[1], xyzw[2]);
}

Quaternion decode_spz_rotation(const SpzHeader& header, const std::byte* at) {
  return header.version < 3 ? decode_xyz(at) : decode_smallest_three(load<std::uint32_t>(at));
}

}  // namespace swiftgs::io
