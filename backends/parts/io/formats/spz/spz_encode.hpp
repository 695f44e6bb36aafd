// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The quantised values of SPZ versions 3 and 4, encoded, and how far from zero their positions reach.

#include <cstddef>
#include <cstdint>
#include <vector>

#include <swiftgs/frame/math.hpp>
#include <swiftgs/scene.hpp>

#include "scene_building.hpp"
#include "scene_encoding.hpp"
#include "spz_content.hpp"

namespace swiftgs::io {

/// The largest coordinate in steps. Its negative is the least.
inline constexpr double spz_largest_position = (1 << 23) - 1;

struct SpzReach {
  int fractional_bits = 0;              ///< of positions, behind the binary point
  std::vector<std::uint32_t> beyond{};  ///< Gaussians that are farther away, though others are not
  dvec3 middle{0.0};                    ///< of the others

  double largest() const;  ///< coordinate
};

/// 12 bits, as all writers use, if the scene fits. A larger scene gets fewer; with 0 bits, what lies beyond
/// 8,388,607 is clamped. In a scene so small that 1/4096 is coarse, the farthest position lies 16,384 to
/// 32,768 steps off, with at most 24 bits. All readers scale by 1 / (1 << bits).
///
/// Strays, if at most one in 500 Gaussians is one, do not decide if the others were left fewer
/// than 65,536 steps, or fewer than they would have by themselves. These may be `beyond`.
SpzReach reach_of(const Scene& scene);

/// The scene with the Gaussians beyond moved towards the middle until they are in reach, and made smaller
/// alike: from the middle they look as before.
Scene drawn_in(Scene scene, const SpzReach& reach);

/// How numbers of a scene become those of a file.
struct SpzEncoding {
  AxisFlip flip{};  ///< from RDF to the axes of the file
  int fractional_bits = 0;
};

/// Encodes an attribute of Gaussians [begin, end), all of finite numbers. Returns how many values lie outside
/// of what the format holds, and were clamped.
std::uint64_t encode_spz(const Scene& scene, const SpzEncoding& encoding, SpzAttribute attribute,
                         std::size_t begin, std::size_t end, std::byte* to);

/// Tells `losses` what an attribute of Gaussians [begin, end) became, unless it is rotations or harmonics.
void measure_spz(const SpzHeader& header, const AxisFlip& flip, SpzAttribute attribute, std::size_t begin,
                 std::size_t end, const std::byte* from, LossMeter& losses);

}  // namespace swiftgs::io
