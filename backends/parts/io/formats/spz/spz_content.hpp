// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// An SPZ file unpacked, whichever container it came in: header, attribute arrays, their values, and the
/// sixteen coordinate systems.

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <swiftgs/frame/math.hpp>
#include <swiftgs/io/scene_file.hpp>

#include "bytes.hpp"
#include "scene_building.hpp"
#include "tasks.hpp"

namespace swiftgs::io {

inline constexpr std::uint32_t spz_magic = 0x5053474e;      // "NGSP"
inline constexpr std::size_t spz_header_size = 16;          ///< in versions 1 to 3 all of it
inline constexpr std::size_t spz_streams_header_size = 32;  ///< in version 4

struct SpzHeader {
  std::uint32_t version = 0;
  std::uint32_t count = 0;
  int sh_degree = 0;
  int fractional_bits = 0;
  bool antialiased = false;
  bool has_extensions = false;
};

enum SpzAttribute {
  spz_positions,
  spz_alphas,
  spz_colours,
  spz_scales,
  spz_rotations,
  spz_sh,
  spz_attributes
};

/// Bytes that one Gaussian takes in each attribute array.
std::array<std::size_t, spz_attributes> spz_sizes(const SpzHeader& header);

/// Bytes of all attribute arrays together.
std::size_t spz_total(const SpzHeader& header);

inline constexpr std::uint32_t spz_safe_orbit_camera = 0xADBE0002;
inline constexpr std::uint32_t spz_coordinate_system = 0xADBE0003;

/// What the extension records state.
struct SpzExtensions {
  std::uint32_t system = 0;  ///< of coordinates; 0 if unspecified
  std::uint64_t offset = 0;  ///< of that value in the file; 0 if it was unpacked
  std::vector<std::string> notes{};
};

struct SpzContent {
  SpzHeader header;
  std::array<std::span<const std::byte>, spz_attributes> arrays{};
  SpzExtensions extensions{};
  std::unique_ptr<std::byte[]> storage{};
};

/// What a reader wants to hear while a file is unpacked.
struct SpzUnpacking {
  ProgressMeter progress;
  /// Called once all but the harmonics is unpacked. Only then is the count worth the memory of a scene: a
  /// header can claim any.
  std::function<void(const SpzHeader&)> unpacked;
};

/// The fields that all versions share. `first` holds at least 16 bytes.
SpzHeader parse_spz_header(const Source& source, const std::byte* first);

/// The header of a whole file. Nothing else is unpacked or checked.
SpzHeader read_spz_header(const Source& source);
SpzHeader read_spz_gzip_header(const Source& source);  ///< of a file in gzip

/// The first bytes, at most `most`, that a gzip file unpacks to; fewer where it is damaged.
std::string gzip_beginning(std::string_view file, std::size_t most);

/// Whether a gzip file unpacks to an SPZ, or to nothing that would tell.
bool is_gzip_of_spz(std::string_view file);

/// Reads extension records, which start at byte `offset` of the file. Without `offset`, as of records that
/// were unpacked, errors name byte 0.
SpzExtensions parse_spz_extensions(const Source& source, std::span<const std::byte> records,
                                   std::optional<std::uint64_t> offset);

SpzContent unpack_spz_gzip(const Source& source, const SpzUnpacking& unpacking);     ///< versions 1 to 3
SpzContent unpack_spz_plain(const Source& source, const SpzUnpacking& unpacking);    ///< those without gzip
SpzContent unpack_spz_streams(const Source& source, const SpzUnpacking& unpacking);  ///< version 4

/// Sets `content.arrays` to the attribute arrays that lie back to back from `data` on.
void split_arrays(SpzContent& content, const std::byte* data);

/// What each byte stands for.
struct SpzTables {
  SpzTables();

  static vec3 three(const std::array<float, 256>& table, const std::byte* at);

  std::array<float, 256> colour;  ///< SH coefficient of band 0
  std::array<float, 256> scale;   ///< standard deviation
};

/// A position in the axes of the file. Version 1 holds halves, the others 24-bit fixed point.
vec3 decode_spz_position(const SpzHeader& header, const std::byte* at);

float decode_spz_opacity(const std::byte* at);

/// Two bits name the largest of x, y, z, w; the others have ten bits each, the first of them the highest.
Quaternion decode_smallest_three(std::uint32_t packed);

/// A unit quaternion in the axes of the file. Versions 1 and 2 hold x, y, z; the others the smallest three.
Quaternion decode_spz_rotation(const SpzHeader& header, const std::byte* at);

/// How numbers in the axes of an SPZ file become RDF: systems with z up or down are turned a quarter about x
/// first, which makes y their vertical axis, and then all are flipped.
struct SpzAxes {
  AxisFlip flip{};
  bool quarter_turn = false;

  bool operator==(const SpzAxes&) const = default;

  vec3 position(vec3 p) const { return flip.position(quarter_turn ? vec3(p.x, p.z, -p.y) : p); }

  Quaternion rotation(Quaternion q) const {
    constexpr float h = 0.70710678f;
    if (quarter_turn) q = {h * (q.w + q.x), h * (q.x - q.w), h * (q.y + q.z), h * (q.z - q.y)};
    return flip.rotation(q);
  }

  /// What `position` multiplies by.
  dmat3 matrix() const {
    return dmat3(dvec3(position({1, 0, 0})), dvec3(position({0, 1, 0})), dvec3(position({0, 0, 1})));
  }
};

/// By the numbers that SPZ gives them. The letters tell where +x, +y, +z point.
inline constexpr std::array<std::string_view, 17> spz_system_names = {
    "unspecified", "LDB", "RDB", "LUB", "RUB", "LDF", "RDF", "LUF", "RUF",
    "LFD",         "RFD", "LFU", "RFU", "LBD", "RBD", "LBU", "RBU"};

/// The axes of coordinate system 1 to 16. None for any other.
///
/// LFD, RFD, LBU and RBU do not follow their letters: Niantic's library, which writes such files, stores
/// under these names what the letters say turned by 180 degrees about x. So it is read.
inline std::optional<SpzAxes> axes_of_spz_system(std::uint32_t system) {
  if (system < 1 || system > 16) return std::nullopt;
  const auto bit = [&](int i) { return (system - 1) >> i & 1; };
  const float x = bit(0) ? 1.0f : -1.0f, second = bit(1) ? -1.0f : 1.0f, third = bit(2) ? 1.0f : -1.0f;
  if (system <= 8) return SpzAxes{{x, second, third}};
  return SpzAxes{{x, third, second}, true};
}

/// What a frame turns into RDF by; the same turns RDF into it.
inline AxisFlip flip_of(SpzFrame frame) {
  switch (frame) {
    case SpzFrame::luf:
      return luf_to_rdf;
    case SpzFrame::rdf:
    case SpzFrame::raw:
      return {};
    case SpzFrame::specified:
    case SpzFrame::rub:
      break;
  }
  return rub_to_rdf;
}

}  // namespace swiftgs::io
