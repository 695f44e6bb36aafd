// SPDX-License-Identifier: Apache-2.0
#pragma once

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

#include "bytes.hpp"
#include "progress_meter.hpp"

/// @file
/// An SPZ file unpacked: its header and its attribute arrays, whichever container they came in.

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

/// Reads extension records, which start at byte `offset` of the file. If they were unpacked, they have no
/// such place, and errors name byte 0.
SpzExtensions parse_spz_extensions(const Source& source, std::span<const std::byte> records,
                                   std::optional<std::uint64_t> offset);

SpzContent unpack_spz_gzip(const Source& source, const SpzUnpacking& unpacking);     ///< versions 1 to 3
SpzContent unpack_spz_plain(const Source& source, const SpzUnpacking& unpacking);    ///< those without gzip
SpzContent unpack_spz_streams(const Source& source, const SpzUnpacking& unpacking);  ///< version 4

/// Sets `content.arrays` to the attribute arrays that lie back to back from `data` on.
void split_arrays(SpzContent& content, const std::byte* data);

}  // namespace swiftgs::io
