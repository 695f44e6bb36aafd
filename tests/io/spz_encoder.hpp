// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <zstd.h>

#include <swiftgs/scene.hpp>

#include "zip_encoder.hpp"

namespace swiftgs::test {

/// An SPZ file taken apart. A test may falsify any field before `gzip_spz` or `stream_spz` puts it together.
struct SpzParts {
  std::uint32_t version = 2, count = 0;
  std::uint8_t sh_degree = 0, fractional_bits = 12, flags = 0;
  std::vector<std::string> arrays{};  ///< positions, alphas, colours, scales, rotations, SH
  std::string extensions{};
};

inline char quantise(double value) { return char(std::uint8_t(std::clamp(std::round(value), 0.0, 255.0))); }

/// IEEE half of a value that a half holds exactly and that is not subnormal.
inline std::uint16_t to_half(float value) {
  if (value == 0) return 0;
  int exponent;
  const float fraction = std::frexp(std::abs(value), &exponent);
  const int mantissa = int(std::lround((fraction * 2 - 1) * 1024));
  return std::uint16_t((value < 0 ? 0x8000 : 0) | (exponent + 14) << 10 | mantissa);
}

inline void append_rotation(std::string& to, std::uint32_t version, const Quaternion& q) {
  const std::array<double, 4> xyzw = {q.x, q.y, q.z, q.w};
  if (version < 3) {
    for (int i = 0; i < 3; ++i) to += quantise(((q.w < 0 ? -xyzw[i] : xyzw[i]) + 1) * 127.5);
    return;
  }
  int largest = 0;
  for (int i = 1; i < 4; ++i)
    if (std::abs(xyzw[i]) > std::abs(xyzw[largest])) largest = i;
  auto packed = std::uint32_t(largest);
  for (int i = 0; i < 4; ++i) {
    if (i == largest) continue;
    const bool negative = (xyzw[i] < 0) != (xyzw[largest] < 0);
    packed = packed << 10 | std::uint32_t(negative) << 9 |
             std::uint32_t(511 * std::abs(xyzw[i]) / std::sqrt(0.5) + 0.5);
  }
  append(to, packed);
}

/// Quantises `scene`, without any change of axes, as version `version` does.
inline SpzParts encode_spz(const Scene& scene, std::uint32_t version) {
  SpzParts parts{.version = version,
                 .count = std::uint32_t(scene.size()),
                 .sh_degree = std::uint8_t(scene.sh_degree),
                 .arrays = std::vector<std::string>(6)};
  std::string &positions = parts.arrays[0], &alphas = parts.arrays[1], &colours = parts.arrays[2];
  std::string &scales = parts.arrays[3], &rotations = parts.arrays[4], &sh = parts.arrays[5];
  for (std::size_t i = 0; i < scene.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      if (version == 1) {
        append(positions, to_half(scene.means[i][axis]));
      } else {
        const auto fixed = std::uint32_t(std::int32_t(std::lround(scene.means[i][axis] * 4096)));
        for (int byte = 0; byte < 3; ++byte) positions += char(fixed >> 8 * byte & 255);
      }
      colours += quantise(scene.sh0[i][axis] * 0.15 * 255 + 127.5);
      scales += quantise((std::log(scene.scales[i][axis]) + 10) * 16);
    }
    alphas += quantise(scene.opacities[i] * 255);
    append_rotation(rotations, version, scene.rotations[i]);
  }
  for (const float value : scene.sh_rest) sh += quantise(value * 128 + 128);
  return parts;
}

inline std::string spz_header(const SpzParts& parts, std::uint8_t last) {
  std::string header = "NGSP";
  append(header, parts.version), append(header, parts.count);
  for (const std::uint8_t byte : {parts.sh_degree, parts.fractional_bits, parts.flags, last})
    append(header, byte);
  return header;
}

inline std::string plain_spz(const SpzParts& parts) {
  std::string file = spz_header(parts, 0);
  for (const std::string& array : parts.arrays) file += array;
  return file + parts.extensions;
}

inline std::string gzip(const std::string& content) { return deflated(content, 16 + MAX_WBITS); }

/// Versions 1 to 3.
inline std::string gzip_spz(const SpzParts& parts) { return gzip(plain_spz(parts)); }

inline std::string zstd_frame(const std::string& content) {
  std::string packed(ZSTD_compressBound(content.size()), '\0');
  packed.resize(ZSTD_compress(packed.data(), packed.size(), content.data(), content.size(), 3));
  return packed;
}

/// Version 4.
inline std::string stream_spz(const SpzParts& parts) {
  std::string table, streams;
  std::uint8_t count = 0;
  for (const std::string& array : parts.arrays) {
    if (array.empty()) continue;
    const std::string frame = zstd_frame(array);
    append(table, std::uint64_t(frame.size())), append(table, std::uint64_t(array.size()));
    streams += frame;
    ++count;
  }
  std::string file = spz_header(parts, count);
  append(file, std::uint32_t(32 + parts.extensions.size()));
  return file + std::string(12, '\0') + parts.extensions + table + streams;
}

inline std::string pack_spz(const SpzParts& parts) {
  return parts.version < 4 ? gzip_spz(parts) : stream_spz(parts);
}

/// An extension record.
inline std::string spz_extension(std::uint32_t type, const std::string& payload) {
  std::string record;
  append(record, type), append(record, std::uint32_t(payload.size()));
  return record + payload;
}

/// The record that states the axes: 1 to 8 are LDB, RDB, LUB, RUB, LDF, RDF, LUF, RUF.
inline std::string coordinate_system(std::uint32_t system) {
  std::string payload;
  append(payload, system);
  return spz_extension(0xADBE0003, payload);
}

}  // namespace swiftgs::test
