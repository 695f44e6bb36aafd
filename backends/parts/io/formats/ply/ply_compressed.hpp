// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <swiftgs/frame/math.hpp>
#include <swiftgs/io/scene_file.hpp>

#include "ply_header.hpp"

/// @file
/// The PLY of SuperSplat. An element `chunk` holds the ranges of the means, of the logarithms of the scales
/// and of the colours of 256 Gaussians, an element `vertex` four words a Gaussian, and an element `sh`,
/// unless there are no harmonics, a byte a coefficient. Axes are those of INRIA's PLY.

namespace swiftgs::io {

inline constexpr std::size_t chunk_size = 256;
inline constexpr std::array chunk_properties = {
    "min_x",       "min_y",       "min_z",       "max_x",       "max_y",       "max_z",
    "min_scale_x", "min_scale_y", "min_scale_z", "max_scale_x", "max_scale_y", "max_scale_z",
    "min_r",       "min_g",       "min_b",       "max_r",       "max_g",       "max_b"};
inline constexpr std::array vertex_properties = {"packed_position", "packed_rotation", "packed_scale",
                                                 "packed_color"};

/// Range of three values in a chunk.
struct Range3 {
  vec3 low{0.0f}, high{0.0f};
};

/// The row of a chunk. Old files hold no range of colours; theirs is 0 to 1.
struct ChunkRanges {
  Range3 mean, log_scale, colour{.low = vec3(0.0f), .high = vec3(1.0f)};
};

/// Three numbers from 0 to 1 in 11, 10 and 11 bits, the first in the highest.
std::uint32_t pack_fractions(dvec3 fractions);
dvec3 unpack_fractions(std::uint32_t packed);

/// A quaternion without its largest component, whose number (w, x, y, z) is in the highest 2 bits; 10 bits
/// from -sqrt(1/2) to sqrt(1/2) for each other.
std::uint32_t pack_rotation(Quaternion unit);
Quaternion unpack_rotation(std::uint32_t packed);

/// The four words of a Gaussian, in the order of `vertex_properties`.
using PackedVertex = std::array<std::uint32_t, vertex_properties.size()>;

/// What they stand for.
struct Vertex {
  vec3 mean, scale, sh0;
  Quaternion rotation;
  float opacity = 0;
};
Vertex unpacked(const PackedVertex& packed, const ChunkRanges& ranges);

/// 256 values from -4 to 4: the first and the last are the ends, any other lies in the middle of its 256th.
/// Zero is as near to two of them: `lower` chooses. Both in turns do not tint a scene.
std::uint8_t pack_sh(float coefficient, bool lower);
float unpack_sh(std::uint8_t packed);

/// Reads a PLY with an element `chunk`. Throws `FormatError` and `Cancelled`.
SceneFile read_compressed_ply(const Source& source, const PlyHeader& header, const SceneReadOptions& options);

}  // namespace swiftgs::io
