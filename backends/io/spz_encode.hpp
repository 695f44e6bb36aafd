// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include <swiftgs/scene.hpp>

#include "axis_flip.hpp"
#include "spz_content.hpp"

/// @file
/// The quantised values of SPZ versions 3 and 4, encoded.

namespace swiftgs::io {

/// How numbers of a scene become those of a file.
struct SpzEncoding {
  AxisFlip flip{};  ///< from RDF to the axes of the file
  int fractional_bits = 0;
};

/// Bits of positions behind the binary point: 12, as all writers use, if the scene fits. A larger scene gets
/// fewer; with 0 bits, what lies beyond 8,388,607 is clamped. In a scene so small that 1/4096 is coarse, the
/// farthest position lies 16,384 to 32,768 steps off, with at most 24 bits. All readers scale by
/// 1 / (1 << bits).
int choose_fractional_bits(const Scene& scene);

/// Encodes an attribute of Gaussians [begin, end), all of finite numbers. Returns how many values lie outside
/// of what the format holds, and were clamped.
std::uint64_t encode_spz(const Scene& scene, const SpzEncoding& encoding, SpzAttribute attribute,
                         std::size_t begin, std::size_t end, std::byte* to);

}  // namespace swiftgs::io
