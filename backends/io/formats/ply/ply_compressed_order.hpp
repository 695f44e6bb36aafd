// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include <swiftgs/scene.hpp>

namespace swiftgs::io {

/// From 0 to 1 where the viewers that defined the format show it.
vec3 colour_of(const Scene& scene, std::size_t i);

/// A row of a compressed PLY.
struct ChunkRow {
  std::uint32_t gaussian;
  bool fills;  ///< shows nothing: of opacity 0, it fills the rest of a chunk
};

/// All Gaussians, of finite numbers, in the order in which the chunks of a compressed PLY have them. A chunk
/// divides its ranges evenly, so Gaussians of a chunk lie near each other, and those far from all others, or
/// of colours far beyond white, share no chunk with the rest. Rows that show nothing fill the chunks before
/// such a change. A scene of one chunk is not divided.
std::vector<ChunkRow> order_in_chunks(const Scene& scene);

}  // namespace swiftgs::io
