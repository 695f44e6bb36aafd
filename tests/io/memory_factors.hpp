// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

/// @file
/// What docs/formats.md says of the memory that a reader may take, for the tests that hold the readers to it.

namespace swiftgs::test {

/// Bytes for each byte of a file, and beside them.
struct MemoryFactor {
  double times = 0;
  double megabytes = 0;

  double bytes_of(std::size_t file) const { return times * double(file) + megabytes * 1e6; }
};

/// Whatever a file holds, a reader has tables and states of libraries of its own.
inline constexpr double own_megabytes = 1;

inline constexpr MemoryFactor splat_memory{2, own_megabytes};
inline constexpr MemoryFactor ksplat_memory{10, own_megabytes};
inline constexpr MemoryFactor ply_memory{30, own_megabytes};
inline constexpr MemoryFactor spz_memory{5'100, own_megabytes};  ///< versions 1 to 3
inline constexpr MemoryFactor spz_streams_memory{50'000, 20};    ///< version 4
inline constexpr MemoryFactor sog_memory{12'000, 64};
inline constexpr MemoryFactor gltf_memory{2'000, 64};
inline constexpr MemoryFactor gltf_spz_memory{5'200, 84};  ///< with SPZ inside

}  // namespace swiftgs::test
